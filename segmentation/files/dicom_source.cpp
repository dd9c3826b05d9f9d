#include "segmentation/files/dicom_source.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "process/input_file.hpp"
#include "segmentation/files/dicom.hpp"
#include "segmentation/files/dicom_elements.hpp"
#include "segmentation/files/dicom_segmentation.hpp"

namespace borelli {
namespace {

// SpecificCharacterSet; StudyDate, StudyTime, AccessionNumber, ReferringPhysicianName; PatientName,
// PatientID, PatientBirthDate, PatientSex, PatientAge, PatientSize, PatientWeight; StudyID
constexpr std::uint32_t patient_tags[] = {0x00080005, 0x00080020, 0x00080030, 0x00080050, 0x00080090,
                                          0x00100010, 0x00100020, 0x00100030, 0x00100040, 0x00101010,
                                          0x00101020, 0x00101030, 0x00200010};

std::string uid_in(const DicomElements& elements, std::uint32_t tag) {
  const std::string uid = elements.text(tag);
  return is_dicom_uid(uid) ? uid : "";
}

// The number of a slice among the frames of its file, from 1; 0: the file has one.
Result<int> frame_of(const DicomSlice& slice, const std::vector<DicomSlice>& frames) {
  if (frames.size() < 2) return 0;
  for (std::size_t n = 0; n < frames.size(); ++n)
    if (frames[n].position == slice.position && frames[n].pixels.offset == slice.pixels.offset &&
        frames[n].pixels.fragments == slice.pixels.fragments)
      return static_cast<int>(n) + 1;
  return failure(slice.path, "changed while it was read");
}

}  // namespace

bool is_dicom_uid(const std::string& text) {
  return !text.empty() && text.size() <= 64 && text.find_first_not_of("0123456789.") == std::string::npos;
}

Result<DicomSource> read_dicom_source(const std::string& scan) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(scan, ignored)) {
    if (auto fine = check_input_file(scan); !fine) return tl::unexpected(fine.error());
    if (!is_dicom_file(scan))
      return bad_use(scan, "is not a DICOM scan; give the folder of the series that the labels belong to");
  }
  const auto stack = find_dicom_stack(scan);
  if (!stack) return tl::unexpected(stack.error());
  DicomSource source{
      .grid = stack->grid, .study_uid = "", .frame_of_reference_uid = "", .images = {}, .patient = {}};
  std::vector<DicomReference> references;  // by slice of the stack
  std::string read_path;
  std::vector<DicomSlice> frames;
  DicomElements elements;
  for (const DicomSlice& slice : stack->slices) {
    if (slice.path != read_path) {
      auto header = read_dicom_elements(slice.path);
      if (!header) return tl::unexpected(header.error());
      if (!*header) return failure(slice.path, "changed while it was read");
      elements = std::move(**header);
      frames.clear(), read_path = slice.path;
      if (elements.item(0x52009230)) {
        auto slices = read_dicom_slices(slice.path);
        if (!slices) return tl::unexpected(slices.error());
        frames = std::move(*slices);
      }
    }
    const auto frame = frame_of(slice, frames);
    if (!frame) return tl::unexpected(frame.error());
    references.push_back(
        {uid_in(elements, 0x0020000e), uid_in(elements, 0x00080016), uid_in(elements, 0x00080018), *frame});
    if (references.size() > 1) continue;
    source.study_uid = uid_in(elements, 0x0020000d);
    source.frame_of_reference_uid = uid_in(elements, 0x00200052);
    for (const std::uint32_t tag : patient_tags)
      if (const std::string text = elements.text(tag); !text.empty()) source.patient[tag] = text;
  }
  source.images.resize(static_cast<std::size_t>(stack->grid.size[2]));
  const auto refer = [&](std::size_t k, double at) {
    const auto n = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(references.size() - 1)));
    const DicomReference& own = references[n];
    if (!own.series_uid.empty() && !own.class_uid.empty() && !own.instance_uid.empty())
      source.images[k].push_back(own);
  };
  for (std::size_t k = 0; k < source.images.size(); ++k) {
    const double at = stack->sources.empty() ? static_cast<double>(k) : stack->sources[k];
    const double below = std::floor(at + 1e-6);
    refer(k, below);
    if (at - below > 1e-6) refer(k, below + 1);
  }
  return source;
}

}  // namespace borelli
