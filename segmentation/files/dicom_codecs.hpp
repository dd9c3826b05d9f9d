// Packed pixels of DICOM that a library unpacks: JPEG, JPEG-LS, JPEG 2000.
#pragma once

#include <cstddef>
#include <span>

#include "segmentation/dicom_slice.hpp"

namespace borelli {

/// Unpacks one frame's stream by GDCM, whose codecs may crash or hang on damaged bytes: called in a child
/// process. What the codec finds (JPEG may know better than the header) replaces in `pixels` what the header
/// says. `to`: rows * columns words of pixels.bits_allocated.
Result<void> unpack_by_codec(const DicomSlice& slice, std::span<const std::byte> stream,
                             std::span<std::byte> to, DicomPixels& pixels);

}  // namespace borelli
