// The data elements of a DICOM file up to its pixels, checked as they are read.
//
// DICOM PS3.5 (7: the data set; A: transfer syntaxes) and PS3.10 (7: preamble and meta information). GDCM
// does not read the headers because Debian builds it with assertions: a damaged length would abort the
// process.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// A data set: a file's, or an item of a sequence in it.
struct DicomItem {
  std::map<std::uint32_t, std::string> values;  ///< by group << 16 | element; short values only
  /// The items of the functional group and segment sequences of multi-frame files and segmentations; no other
  /// sequences.
  std::map<std::uint32_t, std::vector<DicomItem>> sequences;
  bool big_endian = false;

  std::string text(std::uint32_t tag) const;                     ///< without padding; empty where missing
  std::vector<double> decimals(std::uint32_t tag) const;         ///< DS, IS; empty if any is not a number
  std::optional<std::uint16_t> number(std::uint32_t tag) const;  ///< US
  /// The first item of a sequence; null where there is none.
  const DicomItem* item(std::uint32_t tag) const;
};

struct DicomElements : DicomItem {
  std::string transfer_syntax;      ///< UID
  bool packed = false;              ///< pixels are encapsulated (JPEG, RLE ...)
  std::uint64_t deflated_from = 0;  ///< file offset of a deflated data set; 0: not deflated
  /// Offset of the pixels in the file or in the inflated data set; 0: no pixels.
  std::uint64_t pixel_offset = 0;
  std::uint64_t pixel_bytes = 0;  ///< of pixels that are not packed
  /// Offset and length in the file of each fragment of packed pixels, without the offset table (PS3.5, A.4).
  std::vector<std::pair<std::uint64_t, std::uint32_t>> fragments;
};

/// Empty if the file is not DICOM. Errors: a DICOM file that is cut off or damaged.
Result<std::optional<DicomElements>> read_dicom_elements(const std::string& path);

}  // namespace borelli
