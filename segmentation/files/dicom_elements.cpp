#include "segmentation/files/dicom_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>

#include "process/input_file.hpp"
#include "segmentation/files/byte_stream.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

constexpr std::uint32_t undefined = 0xffffffff;
constexpr std::uint32_t item = 0xfffee000, item_end = 0xfffee00d, sequence_end = 0xfffee0dd;
constexpr std::uint32_t pixels = 0x7fe00010;
constexpr std::uint32_t longest_value = 1024;  // longer ones are not numbers, names or UIDs
constexpr int deepest = 32;                    // sequences in sequences
// Limits on the bytes of an inflated header and on the elements of kept sequences, far above any real file.
constexpr std::uint64_t longest_header = std::uint64_t{64} << 20;
constexpr std::size_t most_elements = 4'000'000;

// sequences that are kept: shared and per-frame functional groups (PS3.3, C.7.6.16), segments (C.8.20.2)
constexpr std::array<std::uint32_t, 3> kept_sequences{0x52009229, 0x52009230, 0x00620002};
// inner sequences that are read, for implicit VR, which does not tell sequences from values
constexpr std::array<std::uint32_t, 9> inner_sequences{0x00209111, 0x00209113, 0x00209116,
                                                       0x00289110, 0x00289145, 0x0062000a,
                                                       0x00189329, 0x00189226, 0x00189114};

struct Element {
  std::uint32_t tag = 0;
  std::array<char, 2> vr{};  // zeros where the syntax has none
  std::uint32_t length = 0;
};

struct CloseElements {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

class Reader {
 public:
  bool explicit_vr = true, big_endian = false;
  std::size_t kept = 0;  // elements and items read from kept sequences

  Reader(std::FILE* file, std::uint64_t size) : file_(file), size_(size) {}

  std::uint64_t position() const { return position_; }
  std::uint64_t left() const { return size_ - std::min(size_, position_); }
  // Reads on in the deflated data set (PS3.5, A.5) that starts here. Positions then count in its inflated
  // bytes.
  bool inflate(const std::string& path) {
    auto source = ByteSource::open(path, ByteSource::Packing::raw, position_);
    if (!source) return false;
    inflated_.emplace(std::move(*source));
    size_ = longest_header, position_ = 0;
    return true;
  }
  bool is_inflated() const { return inflated_.has_value(); }
  bool inflated_all() const { return inflated_ && !damaged_; }  // asked after a failed read
  bool seek(std::uint64_t to) {
    if (to > size_ || fseeko(file_.get(), static_cast<off_t>(to), SEEK_SET) != 0) return false;
    position_ = to;
    return true;
  }
  bool skip(std::uint64_t count) {
    if (count > left()) return false;
    if (inflated_) {
      const auto done = inflated_->skip(count);
      position_ += count, damaged_ = damaged_ || !done;
      return done && *done == count;
    }
    std::array<char, 256> dropped;  // reading so few bytes is faster than seeking
    return count <= dropped.size() ? read(dropped.data(), count) : seek(position_ + count);
  }
  bool read(void* to, std::size_t count) {
    if (inflated_) {
      const auto got = inflated_->read({static_cast<std::byte*>(to), count});
      position_ += got ? *got : 0, damaged_ = damaged_ || !got;
      return got && *got == count && position_ <= size_;
    }
    const std::size_t got = std::fread(to, 1, count, file_.get());
    position_ += got;
    return got == count;
  }

  template <class T>
  bool number(T& value) {
    std::array<std::byte, sizeof(T)> raw;
    if (!read(raw.data(), raw.size())) return false;
    if (big_endian != (std::endian::native == std::endian::big)) std::ranges::reverse(raw);
    value = std::bit_cast<T>(raw);
    return true;
  }

  bool element(Element& e) {
    std::uint16_t group = 0, number_in_group = 0;
    if (!number(group) || !number(number_in_group)) return false;
    e.tag = static_cast<std::uint32_t>(group) << 16 | number_in_group;
    e.vr = {};
    if (!explicit_vr || group == 0xfffe) return number(e.length);  // items have no VR in any syntax
    if (!read(e.vr.data(), 2)) return false;
    constexpr std::string_view with_long_length = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
    if (with_long_length.find(std::string_view(e.vr.data(), 2)) != std::string_view::npos) {
      std::uint16_t reserved = 0;
      return number(reserved) && number(e.length);
    }
    std::uint16_t short_length = 0;
    if (!number(short_length)) return false;
    e.length = short_length;
    return true;
  }

  // skips the value of an unwanted element with its nested sequences
  bool skip_value(const Element& e, int depth = 0) {
    if (e.length != undefined) return skip(e.length);
    if (depth > deepest) return false;
    const bool explicit_outside = explicit_vr;
    if (std::string_view(e.vr.data(), 2) == "UN") explicit_vr = false;  // PS3.5, 6.2.2 note 2
    bool whole = false;
    for (Element inner; !whole && element(inner);) {
      whole = inner.tag == sequence_end;
      if (whole) break;
      if (inner.tag != item) break;
      if (inner.length != undefined ? !skip(inner.length) : !skip_item(depth + 1)) break;
    }
    explicit_vr = explicit_outside;
    return whole;
  }

 private:
  bool skip_item(int depth) {
    for (Element e; element(e);) {
      if (e.tag == item_end) return true;
      if (!skip_value(e, depth)) return false;
    }
    return false;
  }

  std::unique_ptr<std::FILE, CloseElements> file_;
  std::optional<ByteSource> inflated_;
  bool damaged_ = false;  // the deflated stream is damaged
  std::uint64_t size_, position_ = 0;
};

// Meta information, group 2: always explicit, little-endian. Leaves the reader at the data set.
bool read_meta(Reader& reader, DicomElements& elements) {
  while (true) {
    const std::uint64_t start = reader.position();
    Element e;
    if (!reader.element(e)) return false;
    if (e.tag >> 16 != 2) return reader.seek(start);
    if (e.length > longest_value) {
      if (!reader.skip(e.length)) return false;
      continue;
    }
    std::string value(e.length, '\0');
    if (!reader.read(value.data(), value.size())) return false;
    elements.values[e.tag] = value;
  }
}

// Some files have no preamble and start with the data set: group 8, its first elements. Says whether they
// may.
bool starts_with_data_set(Reader& reader, DicomElements& elements) {
  std::array<char, 8> start{};
  if (!reader.seek(0) || !reader.read(start.data(), start.size()) || !reader.seek(0)) return false;
  const bool group_8 =
      start[0] == 8 && start[1] == 0 && start[3] == 0 && static_cast<unsigned char>(start[2]) <= 0x18;
  if (!group_8) return false;
  const auto capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  elements.transfer_syntax =
      capital(start[4]) && capital(start[5]) ? "1.2.840.10008.1.2.1" : "1.2.840.10008.1.2";
  return true;
}

// Sets byte order, VR and packing by the transfer syntax. Under the DICOM root, all but the syntaxes named
// here have packed pixels and are explicit little-endian. Returns false if unknown syntax.
bool set_syntax(Reader& reader, const std::string& path, DicomElements& elements) {
  const std::string_view uid = elements.transfer_syntax;
  if (!uid.starts_with("1.2.840.10008.1.2")) return false;
  const bool deflated = uid == "1.2.840.10008.1.2.1.99";
  reader.explicit_vr = uid != "1.2.840.10008.1.2";
  reader.big_endian = elements.big_endian = uid == "1.2.840.10008.1.2.2";
  elements.packed = reader.explicit_vr && uid != "1.2.840.10008.1.2.1" && !elements.big_endian && !deflated;
  elements.deflated_from = deflated ? reader.position() : 0;
  return !deflated || reader.inflate(path);
}

// reads the items of packed pixels; the first is the offset table
bool read_fragments(Reader& reader, DicomElements& elements) {
  for (Element e; reader.element(e);) {
    if (e.tag == sequence_end) {
      if (!elements.fragments.empty()) elements.fragments.erase(elements.fragments.begin());
      return !elements.fragments.empty();
    }
    if (e.tag != item || e.length == undefined) return false;
    elements.fragments.emplace_back(reader.position(), e.length);
    if (!reader.skip(e.length)) return false;
  }
  return false;
}

bool read_items(Reader& reader, const Element& sequence, bool big_endian, std::vector<DicomItem>& items,
                int depth);

// reads one element of an item: its value or its items
bool keep(Reader& reader, const Element& e, DicomItem& into, int depth) {
  if (++reader.kept > most_elements) return false;
  const std::string_view vr(e.vr.data(), 2);
  const bool is_sequence =
      vr == "SQ" || e.length == undefined ||
      (!reader.explicit_vr && std::ranges::find(inner_sequences, e.tag) != inner_sequences.end());
  if (is_sequence) return read_items(reader, e, into.big_endian, into.sequences[e.tag], depth + 1);
  if (e.length > longest_value) return reader.skip_value(e);
  std::string value(e.length, '\0');
  if (!reader.read(value.data(), value.size())) return false;
  into.values[e.tag] = std::move(value);
  return true;
}

bool read_items(Reader& reader, const Element& sequence, bool big_endian, std::vector<DicomItem>& items,
                int depth) {
  if (depth > deepest || (sequence.length != undefined && sequence.length > reader.left())) return false;
  const bool explicit_outside = reader.explicit_vr;
  if (std::string_view(sequence.vr.data(), 2) == "UN") reader.explicit_vr = false;  // PS3.5, 6.2.2 note 2
  const auto end = sequence.length == undefined ? ~std::uint64_t{0} : reader.position() + sequence.length;
  bool whole = sequence.length != undefined;
  while (reader.position() < end) {
    Element e;
    if (!reader.element(e)) return false;
    if (e.tag == sequence_end && sequence.length == undefined) {
      whole = true;
      break;
    }
    if (e.tag != item) return false;
    if (e.length != undefined && e.length > reader.left()) return false;
    if (++reader.kept > most_elements) return false;
    items.emplace_back();
    items.back().big_endian = big_endian;
    const auto item_ends = e.length == undefined ? ~std::uint64_t{0} : reader.position() + e.length;
    while (reader.position() < item_ends) {
      Element inner;
      if (!reader.element(inner)) return false;
      if (inner.tag == item_end && e.length == undefined) break;
      if (!keep(reader, inner, items.back(), depth)) return false;
    }
  }
  reader.explicit_vr = explicit_outside;
  return whole;
}

// reads the data set up to its pixels; false if it is cut off or damaged
bool read_data_set(Reader& reader, DicomElements& elements) {
  std::uint32_t before = 0;
  while (reader.left() > 0) {
    Element e;
    const std::uint64_t start = reader.position();
    if (!reader.element(e)) return reader.inflated_all() && reader.position() == start;
    if (e.tag <= before) return false;  // tags rise
    before = e.tag;
    if (e.tag == pixels) {
      elements.pixel_offset = reader.position();
      if (elements.packed) return e.length == undefined && read_fragments(reader, elements);
      elements.pixel_bytes = e.length;
      return e.length != undefined && (e.length <= reader.left() || reader.is_inflated());
    }
    if (std::ranges::find(kept_sequences, e.tag) != kept_sequences.end()) {
      if (!read_items(reader, e, elements.big_endian, elements.sequences[e.tag], 0)) return false;
      continue;
    }
    if (e.length > longest_value) {
      if (!reader.skip_value(e)) return false;
      continue;
    }
    std::string value(e.length, '\0');
    if (!reader.read(value.data(), value.size())) return false;
    elements.values[e.tag] = value;
  }
  return true;
}

}  // namespace

const DicomItem* DicomItem::item(std::uint32_t tag) const {
  const auto it = sequences.find(tag);
  return it == sequences.end() || it->second.empty() ? nullptr : &it->second.front();
}

std::string DicomItem::text(std::uint32_t tag) const {
  const auto it = values.find(tag);
  if (it == values.end()) return {};
  const std::string_view value = it->second;
  return std::string(trimmed(value.substr(0, value.find('\0'))));
}

std::vector<double> DicomItem::decimals(std::uint32_t tag) const {
  const std::string value = text(tag);
  std::vector<double> numbers;
  for (std::size_t from = 0; from < value.size();) {
    const std::size_t to = std::min(value.find('\\', from), value.size());
    const auto number = number_in(std::string_view(value).substr(from, to - from));
    if (!number || std::isnan(*number)) return {};
    numbers.push_back(*number);
    from = to + 1;
  }
  return numbers;
}

std::optional<std::uint16_t> DicomItem::number(std::uint32_t tag) const {
  const auto it = values.find(tag);
  if (it == values.end() || it->second.size() < 2) return std::nullopt;
  const auto low = static_cast<unsigned char>(it->second[big_endian ? 1 : 0]);
  const auto high = static_cast<unsigned char>(it->second[big_endian ? 0 : 1]);
  return static_cast<std::uint16_t>(low | high << 8);
}

Result<std::optional<DicomElements>> read_dicom_elements(const std::string& path) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (!file) return bad_use(path, "cannot be opened: " + std::string(std::strerror(errno)));
  std::error_code trouble;
  Reader reader(file, std::filesystem::file_size(path, trouble));
  DicomElements elements;
  std::array<char, 4> magic{};
  const bool preamble =
      reader.skip(128) && reader.read(magic.data(), 4) && std::memcmp(magic.data(), "DICM", 4) == 0;
  if (!preamble && !starts_with_data_set(reader, elements)) return std::nullopt;
  if (preamble) {
    if (!read_meta(reader, elements))
      return failure(path, "is a DICOM file, but is cut off or damaged in its first elements");
    elements.transfer_syntax = elements.text(0x00020010);
  }
  if (!set_syntax(reader, path, elements))
    return failure(
        path,
        fmt::format(
            "is a DICOM file with an unsupported transfer syntax ('{}'); convert it to an uncompressed one",
            elements.transfer_syntax));
  if (!read_data_set(reader, elements)) {
    if (!preamble) return std::nullopt;  // another kind of file that starts alike by chance
    return failure(path,
                   fmt::format("is a DICOM file, but is cut off or damaged near byte {}", reader.position()));
  }
  return elements;
}

}  // namespace borelli
