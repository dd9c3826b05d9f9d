// Builds DICOM files element by element (PS3.5, PS3.10), explicit VR, little-endian.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace borelli::mutation {

template <class T>
std::string little_endian(T value) {
  std::string out(sizeof value, '\0');
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}

struct DataSet {
  std::string bytes;

  DataSet& add(std::uint32_t tag, const std::string& vr, std::string value) {
    if (value.size() % 2) value += vr == "UI" || vr == "OB" ? '\0' : ' ';
    head(tag, vr, static_cast<std::uint32_t>(value.size()));
    bytes += value;
    return *this;
  }
  DataSet& number(std::uint32_t tag, std::uint16_t value) { return add(tag, "US", little_endian(value)); }
  /// `undefined`: delimiters end the sequence and its items; otherwise lengths do (PS3.5, 7.5).
  DataSet& sequence(std::uint32_t tag, const std::vector<DataSet>& items, bool undefined = false) {
    std::string value;
    for (const DataSet& item : items) {
      value += item_head(undefined ? undefined_length : static_cast<std::uint32_t>(item.bytes.size())) +
               item.bytes;
      if (undefined) value += "\xfe\xff\x0d\xe0" + std::string(4, '\0');
    }
    if (!undefined) return add(tag, "SQ", value);
    head(tag, "SQ", undefined_length);
    bytes += value + "\xfe\xff\xdd\xe0" + std::string(4, '\0');
    return *this;
  }
  /// Encapsulated pixels, one fragment per frame (PS3.5, A.4).
  DataSet& packed_pixels(const std::vector<std::string>& frames) {
    head(0x7fe00010, "OB", undefined_length);
    bytes += item_head(0);
    for (std::string frame : frames) {
      if (frame.size() % 2) frame += '\0';
      bytes += item_head(static_cast<std::uint32_t>(frame.size())) + frame;
    }
    bytes += "\xfe\xff\xdd\xe0" + std::string(4, '\0');
    return *this;
  }

 private:
  static constexpr std::uint32_t undefined_length = 0xffffffff;
  void head(std::uint32_t tag, const std::string& vr, std::uint32_t size) {
    bytes += little_endian(static_cast<std::uint16_t>(tag >> 16)) +
             little_endian(static_cast<std::uint16_t>(tag)) + vr;
    if (vr == "OB" || vr == "OW" || vr == "SQ")
      bytes += std::string(2, '\0') + little_endian(size);
    else
      bytes += little_endian(static_cast<std::uint16_t>(size));
  }
  static std::string item_head(std::uint32_t size) {
    return std::string("\xfe\xff\0\xe0", 4) + little_endian(size);
  }
};

/// Preamble and meta information, before a data set.
inline std::string dicom_head(const std::string& sop_class, const std::string& transfer_syntax) {
  DataSet meta;
  meta.add(0x00020001, "OB", std::string("\0\1", 2))
      .add(0x00020002, "UI", sop_class)
      .add(0x00020003, "UI", "1.2.3.4")
      .add(0x00020010, "UI", transfer_syntax);
  DataSet length;
  length.add(0x00020000, "UL", little_endian(static_cast<std::uint32_t>(meta.bytes.size())));
  return std::string(128, '\0') + "DICM" + length.bytes + meta.bytes;
}

inline const std::string plain_syntax = "1.2.840.10008.1.2.1";

}  // namespace borelli::mutation
