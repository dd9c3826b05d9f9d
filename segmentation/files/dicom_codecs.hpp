// Unpacks DICOM pixels by GDCM: JPEG, JPEG-LS, JPEG 2000.
#pragma once

#include <cstddef>
#include <span>

#include "segmentation/files/dicom_slice.hpp"

namespace borelli {

/// Loads the codecs. Call it before the child process that uses them is made. Errors: not installed.
Result<void> load_codecs();

/// Unpacks one frame's stream into `to`: rows * columns words of pixels.bits_allocated. Call it in a child
/// process: GDCM's codecs may crash or hang on damaged bytes. The codec's bits stored, high bit and sign
/// replace the header's in `pixels`, since JPEG may contradict the header. Errors: an unknown or damaged
/// packing.
Result<void> unpack_by_codec(const DicomSlice& slice, std::span<const std::byte> stream,
                             std::span<std::byte> to, DicomPixels& pixels);

}  // namespace borelli
