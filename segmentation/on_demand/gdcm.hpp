// Functions of the library that calls GDCM: decoding of JPEG, JPEG-LS and JPEG 2000.
#pragma once

#include <cstddef>
#include <span>

#include "segmentation/files/dicom_slice.hpp"

namespace borelli {

struct GdcmFunctions {
  static constexpr const char* library = "borelli_gdcm";
  /// See unpack_by_codec in files/dicom_codecs.hpp.
  Result<void> (*unpack)(const DicomSlice& slice, std::span<const std::byte> stream, std::span<std::byte> to,
                         DicomPixels& pixels);
};

}  // namespace borelli
