#include "segmentation/files/dicom_labels.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "process/memory.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/files/dicom_data_set.hpp"
#include "segmentation/files/terminology.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double most_shear = 1e-4;  // cosine between rows and columns: a twentieth of a voxel in 512
constexpr const char* segmentation_class = "1.2.840.10008.5.1.4.1.1.66.4";

// ---- values ----

// The number in the at most 16 characters of DS (PS3.5, 6.2).
std::string ds_text(double number) {
  std::string text = fmt::format("{}", number + 0.0);
  for (int digits = 16; text.size() > 16; --digits) text = fmt::format("{:.{}g}", number, digits);
  return text;
}

std::string ds_text(const Vector3d& v) { return ds_text(v[0]) + "\\" + ds_text(v[1]) + "\\" + ds_text(v[2]); }

std::string little_endian(std::uint64_t number, int bytes) {
  std::string out;
  for (int n = 0; n < bytes; ++n) out += static_cast<char>(number >> 8 * n & 0xff);
  return out;
}

DicomElement us_element(std::uint32_t tag, std::uint64_t number) {
  return {tag, "US", little_endian(number, 2)};
}

DicomElement tag_element(std::uint32_t tag, std::uint32_t of) {
  return {tag, "AT", little_endian(of >> 16, 2) + little_endian(of & 0xffff, 2)};
}

DicomElement sequence_element(std::uint32_t tag, std::vector<DicomDataSet> items) {
  return {tag, "SQ", "", std::move(items)};
}

DicomElement code_element(std::uint32_t tag, const CodedTerm& term, DicomDataSet more = {}) {
  DicomDataSet item{
      {0x00080100, "SH", term.value}, {0x00080102, "SH", term.scheme}, {0x00080104, "LO", term.meaning}};
  item.insert(item.end(), more.begin(), more.end());
  return sequence_element(tag, {std::move(item)});
}

// A UID below 2.25, from a UUID of RFC 9562, version 8, whose other bits are those of a digest (PS3.5, B.2).
std::string uid_of(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr);
  digest[6] = static_cast<unsigned char>((digest[6] & 0x0f) | 0x80);
  digest[8] = static_cast<unsigned char>((digest[8] & 0x3f) | 0x80);
  __extension__ unsigned __int128 number = 0;
  for (int n = 0; n < 16; ++n) number = number << 8 | digest[static_cast<std::size_t>(n)];
  return fmt::format("2.25.{}", number);
}

// ---- the object ----

struct LabelSegment {
  std::uint8_t label = 0;
  std::string name;
  std::vector<std::int64_t> slices;  // that hold it, in the order of frames
};

// The labels that occur, with the slices that hold them, from the lowest along the frames' normal.
std::vector<LabelSegment> segments_of(const LabelMap& labels, bool descending) {
  const std::size_t area = static_cast<std::size_t>(labels.grid.size[0] * labels.grid.size[1]);
  std::array<std::vector<std::int64_t>, 256> slices;
  for (std::int64_t n = 0; n < labels.grid.size[2]; ++n) {
    const std::int64_t k = descending ? labels.grid.size[2] - 1 - n : n;
    std::array<bool, 256> seen{};
    const auto* own = labels.voxels.data() + static_cast<std::size_t>(k) * area;
    for (std::size_t o = 0; o < area; ++o) seen[own[o]] = true;
    for (std::size_t label = 1; label < seen.size(); ++label)
      if (seen[label]) slices[label].push_back(k);
  }
  std::vector<LabelSegment> segments;
  for (std::size_t label = 1; label < slices.size(); ++label) {
    if (slices[label].empty()) continue;
    std::string name = label < labels.names.size() ? labels.names[label] : "";
    if (name.empty()) name = fmt::format("label {}", label);
    segments.push_back({static_cast<std::uint8_t>(label), std::move(name), std::move(slices[label])});
  }
  return segments;
}

class SegmentationObject {
 public:
  SegmentationObject(const LabelMap& labels, const DicomLabelOptions& options)
      : labels_(labels),
        options_(options),
        row_(labels.grid.axes.col(0).normalized()),
        column_(labels.grid.axes.col(1).normalized()),
        normal_(row_.cross(column_).normalized()),
        segments_(segments_of(labels, normal_.dot(labels.grid.axes.col(2)) < 0)) {
    for (const LabelSegment& segment : segments_) frames_ += segment.slices.size();
  }

  Result<void> check(const std::string& path) const {
    const Grid& grid = labels_.grid;
    if (options_.source && !same_grid(grid, options_.source->grid))
      return bad_use(path, "was not written: the labels lie on another grid than the scan");
    if (segments_.empty()) return failure(path, "was not written: the labels contain no labelled voxel");
    if (std::abs(row_.dot(column_)) > most_shear)
      return failure(
          path,
          "was not written: DICOM needs rows and columns at right angles, and the grid is sheared; "
          "write it as .nrrd");
    if (grid.size[0] > 65535 || grid.size[1] > 65535)
      return failure(path, "was not written: DICOM holds at most 65535 rows and columns");
    for (const LabelSegment& segment : segments_)
      if (auto fine = check_name(path, segment.name); !fine) return fine;
    if (bit_bytes() > 4294967294.0)
      return failure(path, fmt::format("was not written: {} frames of {} x {} pixels exceed DICOM's 4 GiB; "
                                       "crop the labels or coarsen them",
                                       frames_, grid.size[0], grid.size[1]));
    // the bits, and GDCM's two copies of them
    return admit_memory(path, fmt::format("{} frames of {} x {} bits", frames_, grid.size[0], grid.size[1]),
                        3 * bit_bytes() + 1e4 * static_cast<double>(frames_));
  }

  DicomDataSet write() {
    take_uids();
    const DicomSource* source = options_.source;
    DicomDataSet set{
        {0x00080008, "CS", "DERIVED\\PRIMARY"},
        {0x00080016, "UI", segmentation_class},
        {0x00080018, "UI", uid("instance")},
        {0x00080060, "CS", "SEG"},
        {0x00080070, "LO", "borelli"},
        {0x0008103e, "LO", "Body parts"},
        {0x00081090, "LO", "borelli"},
        {0x00181000, "LO", "none"},
        {0x00181020, "LO", options_.version},
        {0x0020000d, "UI", source && !source->study_uid.empty() ? source->study_uid : uid("study")},
        {0x0020000e, "UI", uid("series")},
        {0x00200011, "IS", "1000"},
        {0x00200013, "IS", "1"},
        {0x00200052, "UI",
         source && !source->frame_of_reference_uid.empty() ? source->frame_of_reference_uid
                                                           : uid("frame of reference")},
        {0x00201040, "LO", ""},
        {0x00700080, "CS", "BODY_PARTS"},
        {0x00700081, "LO", "Body parts"},
        {0x00700084, "PN", ""}};
    add_patient(set);
    add_pixels(set);
    add_dimensions(set);
    add_segments(set);
    if (const auto series = referenced_series(); !series.empty())
      set.push_back(sequence_element(0x00081115, series));
    add_frames(set);
    return set;
  }

 private:
  // A segment's name is of the type LO (PS3.5, 6.2). The file has one character set: the patient's if the
  // patient is copied, else UTF-8.
  Result<void> check_name(const std::string& path, const std::string& name) const {
    if (name.size() > 64)
      return failure(path, fmt::format("was not written: the name '{}' is longer than DICOM's 64", name));
    const bool ascii = std::ranges::all_of(name, [](char c) { return c >= ' ' && c < 127; });
    const bool control = std::ranges::any_of(name, [](char c) { return (c >= 0 && c < ' ') || c == 127; });
    if (control || name.find('\\') != std::string::npos)
      return failure(path, fmt::format("was not written: DICOM cannot hold the name '{}'", name));
    if (!ascii && character_set() != utf_8)
      return failure(path,
                     fmt::format("was not written: the name '{}' and the patient's need different character "
                                 "sets; rename it, or leave --patient out",
                                 name));
    return {};
  }

  static constexpr const char* utf_8 = "ISO_IR 192";
  bool with_patient() const { return options_.patient && options_.source; }
  std::string of_patient(std::uint32_t tag) const {
    const auto& patient = options_.source->patient;
    const auto it = patient.find(tag);
    return !with_patient() || it == patient.end() ? "" : it->second;
  }
  std::string character_set() const { return with_patient() ? of_patient(0x00080005) : utf_8; }

  double bit_bytes() const {
    return std::ceil(static_cast<double>(frames_) * static_cast<double>(labels_.grid.size[0]) *
                     static_cast<double>(labels_.grid.size[1]) / 8);
  }

  // What the UIDs come from: all that the file says.
  void take_uids() {
    const Grid& grid = labels_.grid;
    const std::string_view voxels(reinterpret_cast<const char*>(labels_.voxels.data()),
                                  labels_.voxels.size());
    std::string all =
        uid_of(voxels) + fmt::format(" {} {} {} {} {}", grid.size[0], grid.size[1], options_.version,
                                     with_patient(), options_.source != nullptr);
    for (const LabelSegment& segment : segments_) all += fmt::format(" {}={}", segment.label, segment.name);
    for (int c = 0; c < 3; ++c) all += " " + ds_text(grid.axes.col(c));
    all += " " + ds_text(grid.origin);
    if (const DicomSource* source = options_.source) {
      all += " " + source->study_uid + " " + source->frame_of_reference_uid;
      for (const auto& slice : source->images)
        for (const DicomReference& image : slice)
          all += fmt::format(" {} {}", image.instance_uid, image.frame);
      if (with_patient())
        for (const auto& [tag, text] : source->patient) all += fmt::format(" {}={}", tag, text);
    }
    seed_ = uid_of(all);
  }
  std::string uid(const char* role) const { return uid_of(seed_ + " " + role); }

  void add_patient(DicomDataSet& set) const {
    if (!character_set().empty()) set.push_back({0x00080005, "CS", character_set()});
    const auto copy = [&](std::uint32_t tag, const char* vr, bool needed) {
      const std::string text = options_.source ? of_patient(tag) : "";
      if (needed || !text.empty()) set.push_back({tag, vr, text});
    };
    copy(0x00080020, "DA", true), copy(0x00080030, "TM", true), copy(0x00080050, "SH", true);
    copy(0x00080090, "PN", true), copy(0x00100010, "PN", true), copy(0x00100020, "LO", true);
    copy(0x00100030, "DA", true), copy(0x00100040, "CS", true), copy(0x00200010, "SH", true);
    copy(0x00101010, "AS", false), copy(0x00101020, "DS", false), copy(0x00101030, "DS", false);
    const std::string date = options_.source ? of_patient(0x00080020) : "",
                      time = options_.source ? of_patient(0x00080030) : "";
    set.push_back({0x00080023, "DA", date.empty() ? "19700101" : date});
    set.push_back({0x00080033, "TM", date.empty() || time.empty() ? "000000" : time});
    if (with_patient()) return;
    set.push_back({0x00120062, "CS", "YES"});
    set.push_back({0x00120063, "LO", "Patient, study and dates left empty"});
    set.push_back({0x00280303, "CS", "REMOVED"});
  }

  void add_pixels(DicomDataSet& set) const {
    const Grid& grid = labels_.grid;
    const auto area = static_cast<std::size_t>(grid.size[0] * grid.size[1]);
    // frames without gaps, the least significant bit of a byte first (PS3.5, 8.1.1)
    std::string bits((frames_ * area + 7) / 8, '\0');
    std::size_t bit = 0;
    for (const LabelSegment& segment : segments_)
      for (const std::int64_t k : segment.slices) {
        const auto* own = labels_.voxels.data() + static_cast<std::size_t>(k) * area;
        for (std::size_t o = 0; o < area; ++o, ++bit)
          if (own[o] == segment.label) bits[bit / 8] = static_cast<char>(bits[bit / 8] | 1 << bit % 8);
      }
    set.push_back(us_element(0x00280002, 1)), set.push_back({0x00280004, "CS", "MONOCHROME2"});
    set.push_back({0x00280008, "IS", fmt::format("{}", frames_)});
    set.push_back(us_element(0x00280010, static_cast<std::uint64_t>(grid.size[1])));
    set.push_back(us_element(0x00280011, static_cast<std::uint64_t>(grid.size[0])));
    set.push_back(us_element(0x00280100, 1)), set.push_back(us_element(0x00280101, 1));
    set.push_back(us_element(0x00280102, 0)), set.push_back(us_element(0x00280103, 0));
    set.push_back({0x00282110, "CS", "00"});
    set.push_back({0x7fe00010, "OB", std::move(bits)});
  }

  // Frames are indexed by segment, then by place (PS3.3, C.7.6.17).
  void add_dimensions(DicomDataSet& set) const {
    const std::string own = uid("dimensions");
    const auto dimension = [&](std::uint32_t of, std::uint32_t group, const char* what) {
      return DicomDataSet{{0x00209164, "UI", own},
                          tag_element(0x00209165, of),
                          tag_element(0x00209167, group),
                          {0x00209421, "LO", what}};
    };
    set.push_back(sequence_element(0x00209221, {{{0x00209164, "UI", own}}}));
    set.push_back(
        sequence_element(0x00209222, {dimension(0x0062000b, 0x0062000a, "Referenced Segment Number"),
                                      dimension(0x00200032, 0x00209113, "Image Position (Patient)")}));
  }

  void add_segments(DicomDataSet& set) const {
    std::vector<DicomDataSet> items;
    for (const LabelSegment& segment : segments_) {
      const SegmentTerms terms = terms_of_class(segment.name);
      const bool known = terms.type.meaning != "Tissue";
      const auto side = [](std::uint32_t tag, const CodedTerm& term) {
        return term.value.empty() ? DicomDataSet{} : DicomDataSet{code_element(tag, term)};
      };
      DicomDataSet item{code_element(0x00620003, known ? CodedTerm{"SCT", "123037004", "Anatomical Structure"}
                                                       : terms.type),
                        us_element(0x00620004, items.size() + 1),
                        {0x00620005, "LO", segment.name},
                        {0x00620008, "CS", "AUTOMATIC"},
                        {0x00620009, "LO", "borelli " + options_.version},
                        code_element(0x0062000f, terms.type, side(0x00620011, terms.modifier))};
      if (!terms.region.value.empty())
        item.push_back(code_element(0x00082218, terms.region, side(0x00082220, terms.region_modifier)));
      items.push_back(std::move(item));
    }
    set.push_back({0x00620001, "CS", "BINARY"});
    set.push_back({0x00620013, "CS", "NO"});  // segments do not overlap
    set.push_back(sequence_element(0x00620002, std::move(items)));
  }

  // Referenced Series Sequence (C.12.2): each image once.
  std::vector<DicomDataSet> referenced_series() const {
    std::vector<std::pair<std::string, std::vector<DicomDataSet>>> series;
    if (!options_.source) return {};
    std::string before;
    for (const auto& slice : options_.source->images)
      for (const DicomReference& image : slice) {
        if (image.instance_uid == before) continue;
        before = image.instance_uid;
        auto own = std::ranges::find(series, image.series_uid, [](const auto& s) { return s.first; });
        if (own == series.end()) own = series.insert(own, {image.series_uid, {}});
        own->second.push_back({{0x00081150, "UI", image.class_uid}, {0x00081155, "UI", image.instance_uid}});
      }
    std::vector<DicomDataSet> items;
    for (auto& [series_uid, images] : series)
      items.push_back({{0x0020000e, "UI", series_uid}, sequence_element(0x0008114a, std::move(images))});
    return items;
  }

  // Derivation Image (C.7.6.16.2.6): the images behind slice k.
  DicomElement derivation(std::int64_t k) const {
    std::vector<DicomDataSet> images;
    for (const DicomReference& image : options_.source->images[static_cast<std::size_t>(k)]) {
      DicomDataSet item{
          {0x00081150, "UI", image.class_uid},
          {0x00081155, "UI", image.instance_uid},
          {0x0028135a, "CS", "YES"},  // spatial locations preserved
          code_element(0x0040a170, {"DCM", "121322", "Source image for image processing operation"})};
      if (image.frame > 0) item.push_back({0x00081160, "IS", fmt::format("{}", image.frame)});
      images.push_back(std::move(item));
    }
    if (images.empty()) return sequence_element(0x00089124, {});
    return sequence_element(0x00089124, {{sequence_element(0x00082112, std::move(images)),
                                          code_element(0x00089215, {"DCM", "113076", "Segmentation"})}});
  }

  // Functional groups (C.7.6.16)
  void add_frames(DicomDataSet& set) const {
    const Grid& grid = labels_.grid;
    const Vector3d spacing = grid.spacing();
    const double between = std::abs(normal_.dot(grid.axes.col(2)));
    const DicomDataSet measures{{0x00180050, "DS", ds_text(between)},
                                {0x00180088, "DS", ds_text(between)},
                                {0x00280030, "DS", ds_text(spacing[1]) + "\\" + ds_text(spacing[0])}};
    set.push_back(sequence_element(
        0x52009229,
        {{sequence_element(0x00289110, {measures}),
          sequence_element(0x00209116, {{{0x00200037, "DS", ds_text(row_) + "\\" + ds_text(column_)}}})}}));
    const bool descending = normal_.dot(grid.axes.col(2)) < 0;
    std::vector<DicomDataSet> frames;
    for (std::size_t s = 0; s < segments_.size(); ++s)
      for (const std::int64_t k : segments_[s].slices) {
        const auto place = static_cast<std::uint64_t>(descending ? grid.size[2] - k : k + 1);
        const Vector3d position = grid.point(0, 0, k);
        frames.push_back(
            {sequence_element(0x00209111,
                              {{{0x00209157, "UL", little_endian(s + 1, 4) + little_endian(place, 4)}}}),
             sequence_element(0x00209113, {{{0x00200032, "DS", ds_text(position)}}}),
             sequence_element(0x0062000a, {{us_element(0x0062000b, s + 1)}})});
        if (options_.source) frames.back().push_back(derivation(k));
      }
    set.push_back(sequence_element(0x52009230, std::move(frames)));
  }

  const LabelMap& labels_;
  const DicomLabelOptions& options_;
  Vector3d row_, column_, normal_;
  std::vector<LabelSegment> segments_;
  std::size_t frames_ = 0;
  std::string seed_;
};

}  // namespace

Result<void> write_dicom_labels(const std::string& path, const LabelMap& labels,
                                const DicomLabelOptions& options) {
  if (labels.voxels.size() != labels.grid.count())
    return failure(path, fmt::format("was not written: the grid has {} voxels, and the volume has {}",
                                     labels.grid.count(), labels.voxels.size()));
  SegmentationObject object(labels, options);
  if (auto fine = object.check(path); !fine) return fine;
  return write_dicom(path, object.write());
}

}  // namespace borelli
