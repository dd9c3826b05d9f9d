#include "segmentation/files/volume_formats.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

Result<ImageHeader> read_nifti(const std::string& path) {
  if (!format_of(path, &VolumeFormat::halves).format) return read_nifti_header(path);
  const std::string header = half_of_nifti_pair(path, ".hdr");
  if (header.empty()) return bad_use(path, "is half of a NIfTI pair; put its header (.hdr) beside it");
  return read_nifti_header(header);
}

}  // namespace

const std::vector<VolumeFormat>& volume_formats() {
  static const std::vector<VolumeFormat> formats{
      {{".nii.gz", ".nii", ".hdr.gz", ".hdr"},
       {".img.gz", ".img"},
       {".nii.gz", ".nii"},
       read_nifti,
       write_nifti},
      {{".nrrd", ".nhdr"}, {}, {".nrrd"}, read_nrrd_header, write_nrrd},
      {{".mha", ".mhd"}, {}, {".mha"}, read_metaimage_header, write_metaimage}};
  return formats;
}

NamedFormat format_of(std::string_view path, Endings endings) {
  const std::string lower = lower_case(std::string(path));
  for (const VolumeFormat& format : volume_formats())
    for (const std::string_view ending : format.*endings)
      if (lower.size() > ending.size() && lower.ends_with(ending)) return {&format, ending};
  return {};
}

std::string endings_in_words(Endings endings) {
  std::vector<std::string_view> all;
  for (const VolumeFormat& format : volume_formats())
    all.insert(all.end(), (format.*endings).begin(), (format.*endings).end());
  const std::string_view last = all.back();
  all.pop_back();
  return fmt::format("{} or {}", fmt::join(all, ", "), last);
}

}  // namespace borelli
