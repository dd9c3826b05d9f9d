#include "segmentation/files/dicom_codecs.hpp"

#include "process/on_demand.hpp"
#include "segmentation/on_demand/gdcm.hpp"

namespace borelli {

Result<void> load_codecs() {
  return on_demand<GdcmFunctions>().map([](const GdcmFunctions*) {});
}

Result<void> unpack_by_codec(const DicomSlice& slice, std::span<const std::byte> stream,
                             std::span<std::byte> to, DicomPixels& pixels) {
  const auto gdcm = on_demand<GdcmFunctions>();
  if (!gdcm) return tl::unexpected(gdcm.error());
  return (*gdcm)->unpack(slice, stream, to, pixels);
}

}  // namespace borelli
