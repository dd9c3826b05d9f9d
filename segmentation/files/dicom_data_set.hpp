// A DICOM data set as plain data, and its file. GDCM writes it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct DicomElement;

/// The elements of a file or of a sequence's item (PS3.5, 7), in any order.
using DicomDataSet = std::vector<DicomElement>;

struct DicomElement {
  std::uint32_t tag = 0;  ///< group << 16 | element
  const char* vr = "";    ///< value representation (PS3.5, 6.2); "SQ": `items` count
  /// The value's bytes, little-endian; the writer pads them to even length. Several texts: with a backslash
  /// between them.
  std::string value;
  std::vector<DicomDataSet> items = {};
};

/// Writes a file with preamble and meta information, explicit little-endian. `set` holds SOPClassUID and
/// SOPInstanceUID. Errors: as ByteSink; GDCM is missing.
Result<void> write_dicom(const std::string& path, const DicomDataSet& set);

}  // namespace borelli
