// Builds DICOM files for tests, element by element after PS3.5.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

namespace borelli {

// A data set in explicit little-endian, elements in the order of their tags.
struct DataSet {
  std::string bytes;

  template <class T>
  static std::string raw(T value) {
    std::string out(sizeof value, '\0');
    std::memcpy(out.data(), &value, sizeof value);
    return out;
  }
  DataSet& add(std::uint32_t tag, const std::string& vr, std::string value) {
    if (value.size() % 2) value += vr == "UI" || vr == "OB" ? '\0' : ' ';
    bytes += raw(static_cast<std::uint16_t>(tag >> 16)) + raw(static_cast<std::uint16_t>(tag)) + vr;
    if (vr == "OB" || vr == "OW" || vr == "SQ")
      bytes += std::string(2, '\0') + raw(static_cast<std::uint32_t>(value.size()));
    else
      bytes += raw(static_cast<std::uint16_t>(value.size()));
    bytes += value;
    return *this;
  }
  DataSet& number(std::uint32_t tag, std::uint16_t value) { return add(tag, "US", raw(value)); }
  // `undefined`: undefined length with an end delimiter, as many programs write it
  DataSet& sequence(std::uint32_t tag, const std::vector<DataSet>& items, bool undefined) {
    std::string value;
    const std::uint32_t endless = 0xffffffff;
    for (const DataSet& item : items) {
      value += raw<std::uint16_t>(0xfffe) + raw<std::uint16_t>(0xe000);
      value += raw(undefined ? endless : static_cast<std::uint32_t>(item.bytes.size())) + item.bytes;
      if (undefined) value += raw<std::uint16_t>(0xfffe) + raw<std::uint16_t>(0xe00d) + raw<std::uint32_t>(0);
    }
    if (!undefined) return add(tag, "SQ", value);
    bytes += raw(static_cast<std::uint16_t>(tag >> 16)) + raw(static_cast<std::uint16_t>(tag)) + "SQ";
    bytes += std::string(2, '\0') + raw(endless) + value;
    bytes += raw<std::uint16_t>(0xfffe) + raw<std::uint16_t>(0xe0dd) + raw<std::uint32_t>(0);
    return *this;
  }
  void write(const std::string& path, const std::string& sop_class) const {
    DataSet meta;
    meta.add(0x00020001, "OB", std::string("\0\1", 2));
    meta.add(0x00020002, "UI", sop_class)
        .add(0x00020003, "UI", "1.2.3.4")
        .add(0x00020010, "UI", "1.2.840.10008.1.2.1");
    DataSet length;
    length.add(0x00020000, "UL", raw(static_cast<std::uint32_t>(meta.bytes.size())));
    std::ofstream(path, std::ios::binary)
        << std::string(128, '\0') << "DICM" << length.bytes << meta.bytes << bytes;
  }
};

}  // namespace borelli
