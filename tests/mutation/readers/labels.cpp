// Label maps with names beside them, 3D Slicer's segmentations, DICOM-SEG.
#include <algorithm>

#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "tests/mutation/dicom_bytes.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_labels {

Result<void> check(const LabelMap& map) {
  if (map.grid.count() != map.voxels.size() || map.voxels.empty())
    return defect("the grid has another number of voxels than are there");
  return {};
}

Result<void> read(const std::filesystem::path& file) {
  const auto labels = read_labels(file.string());
  if (labels)
    if (auto fine = check(*labels); !fine) return fine;
  const auto numbered = read_numbered_labels(file.string());
  if (!numbered) return tl::unexpected(numbered.error());
  if (auto fine = check(numbered->map); !fine) return fine;
  if (const auto most = std::ranges::max(numbered->map.voxels); most >= numbered->numbers.size())
    return defect("a voxel has a label that has no number");
  if (!labels) return tl::unexpected(labels.error());
  return {};
}

LabelMap small_labels() {
  LabelMap map;
  map.grid = small_volume(false).grid;
  for (std::size_t n = 0; n < map.grid.count(); ++n)
    map.voxels.push_back(static_cast<std::uint8_t>(n % parts.size()));
  for (const Part& part : parts) map.names.emplace_back(part.name);
  return map;
}

TestCase with_names(const std::string& name, const std::string& file) {
  TestCase test{name, {}};
  test.files.push_back(
      {file, written(file, [](const std::string& path) { return write_labels(path, small_labels()); })});
  std::string tsv = "label\tname\n";
  for (std::size_t n = 0; n < parts.size(); ++n)
    tsv += std::to_string(n) + "\t" + std::string(parts[n].name) + "\n";
  test.files.push_back({file.substr(0, file.find('.')) + ".tsv", tsv});
  return test;
}

// As 3D Slicer saves a segmentation: three segments in two layers.
const std::string slicer =
    "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 2 2 1\n"
    "space directions: none (2,0,0) (0,2,0) (0,0,3)\nkinds: list domain domain domain\n"
    "space: left-posterior-superior\nspace origin: (10,20,30)\nencoding: raw\n"
    "Segment0_ID:=Segment_1\nSegment0_Name:=femur left\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
    "Segment1_ID:=Segment_2\nSegment1_Name:=skin\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n"
    "Segment2_ID:=Segment_3\nSegment2_Name:=liver\nSegment2_LabelValue:=2\nSegment2_Layer:=0\n\n";
const std::string layers("\1\0\1\1\2\1\0\1", 8);

std::string dicom_segmentation(bool binary, bool undefined) {
  constexpr int columns = 5, rows = 4;
  std::vector<DataSet> frames, segments;
  std::vector<int> values;
  for (int segment = 1; segment <= 2; ++segment)
    for (int k = segment - 1; k < 3; ++k) {
      DataSet place, of, frame;
      place.add(0x00200032, "DS", "-10\\-20\\" + std::to_string(30 + 3 * k));
      of.number(0x0062000b, static_cast<std::uint16_t>(segment));
      frame.sequence(0x00209113, {place}, undefined).sequence(0x0062000a, {of}, undefined);
      frames.push_back(frame);
      for (int n = 0; n < columns * rows; ++n)
        values.push_back(binary ? n % 3 == segment % 3 : 20 * (n % 10));
    }
  std::string pixels((values.size() + 7) / 8, '\0');
  if (binary)
    for (std::size_t n = 0; n < values.size(); ++n)
      pixels[n / 8] = static_cast<char>(pixels[n / 8] | values[n] << n % 8);
  else
    pixels.assign(values.begin(), values.end());
  DataSet direction, measures, shared, d;
  direction.add(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
  measures.add(0x00180050, "DS", "3").add(0x00180088, "DS", "3").add(0x00280030, "DS", "0.5\\0.75");
  shared.sequence(0x00209116, {direction}, undefined).sequence(0x00289110, {measures}, undefined);
  for (const std::uint16_t n : {1, 2}) {
    DataSet segment;
    segment.number(0x00620004, n).add(0x00620005, "LO", n == 1 ? "Femur left" : "Skin");
    segments.push_back(segment);
  }
  const std::string seg = "1.2.840.10008.5.1.4.1.1.66.4";
  const std::uint16_t bits = binary ? 1 : 8;
  d.add(0x00080016, "UI", seg).add(0x00080018, "UI", "1.2.3.5").add(0x00080060, "CS", "SEG");
  d.add(0x0020000e, "UI", "1.2.9").number(0x00280002, 1).add(0x00280004, "CS", "MONOCHROME2");
  d.add(0x00280008, "IS", std::to_string(frames.size())).number(0x00280010, rows).number(0x00280011, columns);
  d.number(0x00280100, bits)
      .number(0x00280101, bits)
      .number(0x00280102, static_cast<std::uint16_t>(bits - 1));
  d.number(0x00280103, 0).add(0x00620001, "CS", binary ? "BINARY" : "FRACTIONAL");
  d.sequence(0x00620002, segments, undefined);
  if (!binary) d.number(0x0062000e, 200).add(0x00620010, "CS", "PROBABILITY");
  d.sequence(0x52009229, {shared}, undefined).sequence(0x52009230, frames, undefined);
  d.add(0x7fe00010, "OB", pixels);
  return dicom_head(seg, plain_syntax) + d.bytes;
}

std::vector<TestCase> seeds() {
  return {with_names("nifti", "a.nii"),
          with_names("nrrd", "a.nrrd"),
          with_names("metaimage", "a.mha"),
          {"slicer", {{"a.seg.nrrd", slicer + layers}}},
          {"dicom_seg", {{"seg.dcm", dicom_segmentation(true, false)}}},
          {"dicom_seg_undefined", {{"seg.dcm", dicom_segmentation(true, true)}}},
          {"dicom_seg_fractions", {{"seg.dcm", dicom_segmentation(false, false)}}}};
}

}  // namespace of_labels

Reader labels_reader() { return {"labels", of_labels::seeds, of_labels::read}; }

}  // namespace borelli::mutation
