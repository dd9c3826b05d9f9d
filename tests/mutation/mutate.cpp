#include "tests/mutation/mutate.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>

namespace borelli::mutation {
namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 20;

// SplitMix64 (Steele, Lea, Flood 2014): every seed is good.
class Chance {
 public:
  explicit Chance(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  /// 0 to count - 1
  std::size_t below(std::size_t count) { return count == 0 ? 0 : next() % count; }
  bool one_in(std::size_t count) { return below(count) == 0; }
  /// 1 to most, uniform on a logarithmic scale
  std::size_t length(std::size_t most) {
    const double power = std::log2(static_cast<double>(std::max<std::size_t>(most, 1)));
    const double share = static_cast<double>(next() >> 11) * 0x1p-53;
    return std::max<std::size_t>(1, static_cast<std::size_t>(std::exp2(power * share)));
  }
  template <class List>
  decltype(auto) pick(const List& list) {
    return list[below(std::size(list))];
  }

 private:
  std::uint64_t state_;
};

struct Range {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
};

Range some_block(Chance& chance, const std::string& bytes) {
  if (bytes.empty()) return {};
  const std::size_t begin = chance.below(bytes.size());
  return {begin, begin + std::min(chance.length(bytes.size()), bytes.size() - begin)};
}

// The run of characters that `belongs` accepts, at or after a random place.
template <class Belongs>
Range some_run(Chance& chance, const std::string& bytes, Belongs belongs) {
  const std::size_t drawn = chance.below(bytes.size());
  const auto at = std::find_if(bytes.begin() + static_cast<std::ptrdiff_t>(drawn), bytes.end(), belongs);
  std::size_t begin = static_cast<std::size_t>(at - bytes.begin());
  while (begin > 0 && begin < bytes.size() && belongs(bytes[begin - 1])) --begin;
  std::size_t end = begin;
  while (end < bytes.size() && belongs(bytes[end])) ++end;
  return {begin, end};
}

Range some_line(Chance& chance, const std::string& bytes) {
  const std::size_t drawn = chance.below(bytes.size());
  const auto before = drawn == 0 ? bytes.npos : bytes.rfind('\n', drawn - 1);
  const auto after = bytes.find('\n', drawn);
  return {before == bytes.npos ? 0 : before + 1, after == bytes.npos ? bytes.size() : after + 1};
}

bool in_number(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '+';
}
bool in_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

using Edit = void (*)(Chance&, std::string& bytes, const std::string& other);

void flip_bit(Chance& chance, std::string& bytes, const std::string&) {
  char& byte = bytes[chance.below(bytes.size())];
  byte = static_cast<char>(byte ^ 1 << chance.below(8));
}

void set_byte(Chance& chance, std::string& bytes, const std::string&) {
  constexpr std::array values{'\0', '\1', '\x7f', '\x80', '\xff', ' ', '\n', '"', '<', '-', '\\', '\x1b'};
  bytes[chance.below(bytes.size())] = chance.pick(values);
}

// An integer of 2, 4 or 8 bytes becomes a boundary value or moves by a little, in either byte order.
void set_integer(Chance& chance, std::string& bytes, const std::string&) {
  constexpr std::array<std::size_t, 3> sizes{2, 4, 8};
  const std::size_t size = std::min(chance.pick(sizes), bytes.size());
  const std::size_t at = chance.below(bytes.size() - size + 1);
  const bool big_endian = chance.one_in(4);
  const auto place = [&](std::size_t n) { return at + (big_endian ? size - 1 - n : n); };
  std::uint64_t value = 0;
  for (std::size_t n = 0; n < size; ++n)
    value |= std::uint64_t{static_cast<unsigned char>(bytes[place(n)])} << 8 * n;
  const std::uint64_t all = ~std::uint64_t{0} >> (64 - 8 * size), half = all / 2;
  const std::array<std::uint64_t, 11> values{
      0, 1, 2, half, half + 1, all, all - 1, value + 1, value - 1, value * 2, std::uint64_t{1} << 30};
  value = chance.pick(values);
  for (std::size_t n = 0; n < size; ++n) bytes[place(n)] = static_cast<char>(value >> 8 * n);
}

void delete_block(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_block(chance, bytes);
  bytes.erase(r.begin, r.size());
}

void double_block(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_block(chance, bytes);
  bytes.insert(chance.below(bytes.size() + 1), bytes.substr(r.begin, r.size()));
}

void move_block(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_block(chance, bytes);
  const std::string block = bytes.substr(r.begin, r.size());
  bytes.erase(r.begin, r.size());
  bytes.insert(chance.below(bytes.size() + 1), block);
}

void repeat_block(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_block(chance, bytes);
  const std::string block = bytes.substr(r.begin, r.size());
  const std::size_t count = chance.length(std::min<std::size_t>(20000, most_bytes / 4 / block.size()));
  std::string many;
  for (std::size_t n = 0; n < count; ++n) many += block;
  bytes.insert(r.end, many);
}

void cut_off(Chance& chance, std::string& bytes, const std::string&) {
  bytes.resize(chance.below(bytes.size()));
}

void noise(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_block(chance, bytes);
  const std::size_t end = std::min(r.end, r.begin + 64);
  for (std::size_t n = r.begin; n < end; ++n) bytes[n] = static_cast<char>(chance.next());
}

void absurd_number(Chance& chance, std::string& bytes, const std::string&) {
  static const std::vector<std::string> numbers{
      "nan",   "inf",  "-inf", "1e308", "-1e308", "1e-308",      "1e999",        "-1",
      "0",     "-0.0", "",     "1",     "2",      "99999999999", "2147483648",   "-2147483649",
      "65536", "1e9",  "1e17", "0.5",   "1e-20",  "1,5",         "0x1p9",        "18446744073709551616",
      "+3",    "1e",   "--1",  "3 4",   "1e30",   "-1e-300",     "4294967295.0", std::string(400, '9')};
  const Range r = some_run(chance, bytes, in_number);
  bytes.replace(r.begin, r.size(), chance.pick(numbers));
}

void token_of_other(Chance& chance, std::string& bytes, const std::string& other) {
  if (other.empty()) return;
  const auto belongs = chance.one_in(3) ? in_number : in_word;
  const Range from = some_run(chance, other, belongs), to = some_run(chance, bytes, belongs);
  bytes.replace(to.begin, to.size(), other.substr(from.begin, from.size()));
}

void tail_of_other(Chance& chance, std::string& bytes, const std::string& other) {
  if (other.empty()) return;
  bytes.resize(chance.below(bytes.size()));
  bytes += other.substr(chance.below(other.size()));
}

void line_of_other(Chance& chance, std::string& bytes, const std::string& other) {
  if (other.empty()) return;
  const Range from = some_line(chance, other);
  bytes.insert(some_line(chance, bytes).begin, other.substr(from.begin, from.size()));
}

void double_line(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_line(chance, bytes);
  bytes.insert(chance.one_in(2) ? r.begin : some_line(chance, bytes).begin, bytes.substr(r.begin, r.size()));
}

void delete_line(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_line(chance, bytes);
  bytes.erase(r.begin, r.size());
}

void move_line(Chance& chance, std::string& bytes, const std::string&) {
  const Range r = some_line(chance, bytes);
  const std::string line = bytes.substr(r.begin, r.size());
  bytes.erase(r.begin, r.size());
  if (!bytes.empty()) bytes.insert(some_line(chance, bytes).begin, line);
}

void nest(Chance& chance, std::string& bytes, const std::string&) {
  using namespace std::string_literals;
  static const std::vector<std::pair<std::string, std::string>> brackets{
      {"[", "]"},
      {"{\"a\":", "}"},
      {"{a=", "}"},
      {"a.", ""},
      {"(", ")"},
      {"<body>", "</body>"},
      {"<default class=\"a\">", "</default>"},
      {"<frame>", "</frame>"},
      {"<link>", "</link>"},
      {"\0\x52\x30\x92SQ\0\0\xff\xff\xff\xff\xfe\xff\0\xe0\xff\xff\xff\xff"s, ""},  // a DICOM sequence
      {"\xfe\xff\0\xe0\xff\xff\xff\xff"s, "\xfe\xff\x0d\xe0\0\0\0\0"s},             // an item of one
  };
  const auto& [open, close] = chance.pick(brackets);
  const std::size_t depth = chance.length(std::min<std::size_t>(100000, most_bytes / 2 / open.size()));
  const Range held = chance.one_in(2) ? some_run(chance, bytes, in_word) : Range{};
  const std::size_t at = held.size() > 0 ? held.begin : chance.below(bytes.size() + 1);
  std::string deep;
  for (std::size_t n = 0; n < depth; ++n) deep += open;
  deep += bytes.substr(at, held.size());
  if (!chance.one_in(3))
    for (std::size_t n = 0; n < depth; ++n) deep += close;
  bytes.replace(at, held.size(), deep);
}

constexpr std::array<Edit, 10> any_edits{flip_bit,     flip_bit, set_byte,       set_byte,      delete_block,
                                         double_block, cut_off,  token_of_other, tail_of_other, move_block};
constexpr std::array<Edit, 9> binary_edits{set_integer, set_integer, set_integer,  set_integer,  flip_bit,
                                           noise,       nest,        repeat_block, absurd_number};
constexpr std::array<Edit, 14> text_edits{
    absurd_number, absurd_number, absurd_number, absurd_number, token_of_other, token_of_other, double_line,
    delete_line,   move_line,     line_of_other, nest,          repeat_block,   noise,          double_block};

bool is_text(const std::string& bytes) {
  return std::ranges::none_of(bytes.substr(0, 4096), [](unsigned char c) { return c < 7; });
}

void edit(Chance& chance, std::string& bytes, const std::string& other) {
  if (bytes.empty()) {  // nothing to damage: uses another file
    bytes = other;
    return;
  }
  const Edit change = chance.one_in(3) ? chance.pick(any_edits)
                      : is_text(bytes) ? chance.pick(text_edits)
                                       : chance.pick(binary_edits);
  change(chance, bytes, other);
  if (bytes.size() > most_bytes) bytes.resize(most_bytes);
}

// FNV-1a
std::uint64_t hash(std::string_view text) {
  std::uint64_t value = 0xcbf29ce484222325;
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return value;
}

}  // namespace

TestCase mutated(const std::vector<TestCase>& seeds, std::string_view reader, std::uint64_t campaign,
                 std::uint64_t number) {
  Chance chance(hash(reader) ^ (campaign * 0x9e3779b97f4a7c15) ^ (number << 1));
  TestCase test = seeds[number % seeds.size()];
  test.name += "-" + std::to_string(number);
  const std::size_t edits = chance.one_in(3) ? chance.length(16) : 1;
  for (std::size_t n = 0; n < edits; ++n) {
    // the main file more often than the files that it names
    TestFile& file = test.files[chance.one_in(3) ? chance.below(test.files.size()) : 0];
    const TestCase& other = chance.pick(seeds);
    if (file.pack && chance.one_in(3)) file.bytes = file.on_disk(), file.pack = nullptr;
    edit(chance, file.bytes, chance.pick(other.files).bytes);
  }
  return test;
}

}  // namespace borelli::mutation
