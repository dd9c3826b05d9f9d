#include "pipeline/recordings/c3d_parameters.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "error/printable.hpp"

namespace borelli {
namespace {

std::string parameter_capitals(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return out;
}

std::string without_padding(std::string_view text) {
  const std::string_view padding(" \t\r\n\0", 5);
  const std::size_t first = text.find_first_not_of(padding);
  if (first == text.npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(padding) - first + 1));
}

bool is_parameter_name(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

// A record as it stands in the file: `at` is where its own fields begin, behind name and offset.
struct C3dRecord {
  std::string name;
  int group;  // negative: the record names a group
  std::size_t at, next;
};

class C3dSectionReader {
 public:
  C3dSectionReader(std::string_view bytes, C3dProcessor processor, const std::string& file,
                   std::vector<std::string>& warnings)
      : bytes_(bytes), processor_(processor), file_(file), warnings_(warnings) {}

  Result<C3dParameters> read(std::size_t start, std::size_t end) {
    for (std::size_t at = start + 4; at != 0 && at < end;) {  // four bytes of section header stand first
      const auto record = record_at(at);
      if (!record) return tl::unexpected(record.error());
      if (record->name.empty()) break;
      if (!is_parameter_name(record->name)) {
        warnings_.push_back(fmt::format(
            "the parameter section is damaged from byte {} on; later parameters were not read", at));
        break;
      }
      if (record->group < 0)
        names_.emplace(-record->group, record->name);
      else if (auto kept = keep(*record); !kept)
        return tl::unexpected(kept.error());
      at = record->next;
    }
    C3dParameters out;
    for (auto& [group, name, parameter] : found_) {
      const auto owner = names_.find(group);
      if (owner != names_.end())
        out.add(owner->second, name, std::move(parameter));
      else
        warn(name, "belongs to no group");
    }
    return out;
  }

 private:
  tl::unexpected<Error> cut_short(std::size_t at) const {
    return failure(file_, fmt::format("ends in the parameter at byte {} of its parameter section", at));
  }

  void warn(const std::string& name, const std::string& what) {
    if (warnings_.size() < 20) warnings_.push_back(fmt::format("parameter {} {}", printable(name), what));
  }

  std::uint8_t byte(std::size_t at) const { return static_cast<std::uint8_t>(bytes_[at]); }

  Result<C3dRecord> record_at(std::size_t at) const {
    C3dRecord out{{}, 0, at, 0};
    if (at + 2 > bytes_.size()) return cut_short(at);
    const int length = std::abs(static_cast<std::int8_t>(bytes_[at]));  // negative: locked
    if (length == 0) return out;
    out.group = static_cast<std::int8_t>(bytes_[at + 1]);
    const std::size_t offset = at + 2 + static_cast<std::size_t>(length);
    if (offset + 2 > bytes_.size()) return cut_short(at);
    out.name = parameter_capitals(bytes_.substr(at + 2, static_cast<std::size_t>(length)));
    const std::size_t step = c3d_word(bytes_.data() + offset, processor_);
    out.at = offset + 2;
    out.next = step == 0 ? 0 : offset + step;
    return out;
  }

  // type, number of dimensions, dimensions, data
  Result<void> keep(const C3dRecord& record) {
    if (record.at + 2 > bytes_.size()) return cut_short(record.at);
    const int type = static_cast<std::int8_t>(bytes_[record.at]);
    const std::size_t dimensions = byte(record.at + 1);
    if (type != -1 && type != 1 && type != 2 && type != 4)
      return warn(record.name, fmt::format("has unknown type {}", type)), Result<void>{};
    if (dimensions > 7)
      return warn(record.name, fmt::format("has {} dimensions, expected at most 7", dimensions)),
             Result<void>{};
    const std::size_t data = record.at + 2 + dimensions;
    if (data > bytes_.size()) return cut_short(record.at);
    C3dParameter parameter;
    std::size_t count = 1;
    for (std::size_t i = 0; i < dimensions; ++i) {
      parameter.dimensions.push_back(byte(record.at + 2 + i));
      count *= byte(record.at + 2 + i);  // at most 255^7: no overflow of 64 bits
    }
    const auto size = static_cast<std::size_t>(std::abs(type));
    if (record.next != 0 && count > (record.next - std::min(record.next, data)) / size)
      return warn(record.name, "overlaps the next one and was left out"), Result<void>{};
    if (count > (bytes_.size() - data) / size) return cut_short(record.at);
    read_values(parameter, type, data, count);
    found_.push_back({record.group, record.name, std::move(parameter)});
    return {};
  }

  void read_values(C3dParameter& out, int type, std::size_t at, std::size_t count) const {
    out.kind = type == -1  ? C3dParameter::Kind::text
               : type == 1 ? C3dParameter::Kind::byte
               : type == 2 ? C3dParameter::Kind::integer
                           : C3dParameter::Kind::real;
    if (type == -1) {
      out.text = bytes_.substr(at, count);
      return;
    }
    out.numbers.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const char* element = bytes_.data() + at + i * static_cast<std::size_t>(type);
      out.numbers.push_back(type == 1   ? static_cast<std::int8_t>(*element)
                            : type == 2 ? c3d_integer(element, processor_)
                                        : c3d_real(element, processor_));
    }
  }

  struct Found {
    int group;
    std::string name;
    C3dParameter parameter;
  };
  std::string_view bytes_;
  C3dProcessor processor_;
  const std::string& file_;
  std::vector<std::string>& warnings_;
  std::map<int, std::string> names_;
  std::vector<Found> found_;
};

}  // namespace

std::vector<std::string> C3dParameter::texts() const {
  if (kind != Kind::text) return {};
  const std::size_t width = dimensions.size() < 2 ? text.size() : static_cast<std::size_t>(dimensions[0]);
  std::vector<std::string> out;
  for (std::size_t at = 0; width != 0 && at + width <= text.size(); at += width)
    out.push_back(without_padding(std::string_view(text).substr(at, width)));
  return out;
}

const C3dParameter* C3dParameters::find(std::string_view group, std::string_view name) const {
  const auto of_group = groups_.find(group);
  if (of_group == groups_.end()) return nullptr;
  const auto parameter = of_group->second.find(name);
  return parameter == of_group->second.end() ? nullptr : &parameter->second;
}

std::vector<std::string> C3dParameters::texts(std::string_view group, const std::string& name) const {
  std::vector<std::string> out;
  const C3dParameter* parameter = find(group, name);
  for (int sequel = 2; parameter != nullptr; parameter = find(group, name + std::to_string(sequel++)))
    for (std::string& row : parameter->texts()) out.push_back(std::move(row));
  return out;
}

std::vector<double> C3dParameters::numbers(std::string_view group, const std::string& name) const {
  std::vector<double> out;
  const C3dParameter* parameter = find(group, name);
  for (int sequel = 2; parameter != nullptr; parameter = find(group, name + std::to_string(sequel++)))
    out.insert(out.end(), parameter->numbers.begin(), parameter->numbers.end());
  return out;
}

std::optional<double> C3dParameters::number(std::string_view group, std::string_view name) const {
  const C3dParameter* parameter = find(group, name);
  if (parameter == nullptr || parameter->numbers.empty()) return std::nullopt;
  return parameter->numbers.front();
}

std::optional<double> C3dParameters::count(std::string_view group, std::string_view name) const {
  const auto value = number(group, name);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  const C3dParameter::Kind kind = find(group, name)->kind;
  if (kind == C3dParameter::Kind::integer && *value < 0) return *value + 65536;
  if (kind == C3dParameter::Kind::byte && *value < 0) return *value + 256;
  if (*value < 0) return std::nullopt;
  return std::floor(*value);
}

std::string C3dParameters::line(std::string_view group, std::string_view name) const {
  const C3dParameter* parameter = find(group, name);
  const std::vector<std::string> rows =
      parameter == nullptr ? std::vector<std::string>{} : parameter->texts();
  return rows.empty() ? std::string{} : rows.front();
}

void C3dParameters::add(const std::string& group, const std::string& name, C3dParameter parameter) {
  groups_[group].emplace(name, std::move(parameter));
}

Result<C3dParameters> read_c3d_parameters(std::string_view bytes, std::size_t start, std::size_t end,
                                          C3dProcessor processor, const std::string& file,
                                          std::vector<std::string>& warnings) {
  return C3dSectionReader(bytes, processor, file, warnings).read(start, end);
}

}  // namespace borelli
