// Functions of the library that calls GDCM: decoding of JPEG, JPEG-LS and JPEG 2000; writing of DICOM files.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <span>

#include "segmentation/files/dicom_data_set.hpp"
#include "segmentation/files/dicom_slice.hpp"

namespace borelli {

struct GdcmFunctions {
  static constexpr const char* library = "borelli_gdcm";
  /// See unpack_by_codec in files/dicom_codecs.hpp.
  Result<void> (*unpack)(const DicomSlice& slice, std::span<const std::byte> stream, std::span<std::byte> to,
                         DicomPixels& pixels);
  /// See write_dicom in files/dicom_data_set.hpp. False: the stream failed, or GDCM refuses the elements.
  bool (*write)(std::ostream& stream, const DicomDataSet& set);
};

}  // namespace borelli
