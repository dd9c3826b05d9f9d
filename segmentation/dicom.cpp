#include "segmentation/dicom.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>

#include "segmentation/slice_stack.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
using Slices = std::vector<DicomSlice>;

struct Found {
  std::vector<Slices> groups;     // one series, size and orientation each
  std::size_t frames = 0;         // multi-frame files that do not say where their frames are
  std::size_t segmentations = 0;  // DICOM-SEG, which is no scan
  std::size_t colours = 0;
  std::size_t unplaced = 0;  // pictures without position
};

Result<std::vector<std::string>> files_below(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code trouble;
  if (std::filesystem::is_regular_file(folder, trouble)) return std::vector{folder};  // a multi-frame file
  auto it = std::filesystem::recursive_directory_iterator(folder, trouble);
  for (; !trouble && it != std::filesystem::recursive_directory_iterator(); it.increment(trouble))
    if (it->is_regular_file(trouble)) files.push_back(it->path().string());
  if (trouble) return bad_use(folder, "cannot be listed: " + trouble.message());
  std::ranges::sort(files);  // folders list files in any order; the answer must not depend on it
  return files;
}

// Slices of one volume share series, size, orientation and spacing; the last two up to the rounding of their
// decimals.
bool belong_together(const DicomSlice& a, const DicomSlice& b) {
  const auto close = [](double x, double y) { return std::abs(x - y) < 1e-3; };
  return a.series_uid == b.series_uid && a.modality == b.modality && a.rows == b.rows &&
         a.columns == b.columns && (a.along_row - b.along_row).norm() < 2e-3 &&
         (a.along_column - b.along_column).norm() < 2e-3 && close(a.row_spacing, b.row_spacing) &&
         close(a.column_spacing, b.column_spacing);
}

void add_to_groups(std::vector<Slices>& groups, const DicomSlice& slice) {
  const auto group =
      std::ranges::find_if(groups, [&](const Slices& g) { return belong_together(g.front(), slice); });
  if (group == groups.end()) {
    groups.push_back({slice});
  } else {
    group->push_back(slice);
  }
}

Result<Found> find_groups(const std::string& folder, const Progress& progress) {
  const auto files = files_below(folder);
  if (!files) return tl::unexpected(files.error());
  std::vector<Result<Slices>> headers(files->size());
  in_slabs(std::ssize(headers), 0, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t k = from; k < to; ++k) {
      const auto n = static_cast<std::size_t>(k);
      headers[n] = read_dicom_slices((*files)[n]);
      if (!headers[n]) return;
      // headers are a small part of the work: the tenth of the bar, by the thread that called
      if (from == 0 && progress) progress(0.1 * static_cast<double>(k + 1) / static_cast<double>(to));
    }
  });
  Found found;
  for (const Result<Slices>& slices : headers) {
    if (!slices) return tl::unexpected(slices.error());
    for (const DicomSlice& slice : *slices) {
      if (slice.modality == "SEG") {
        ++found.segmentations;
        break;
      } else if (slice.frames > 1) {
        ++found.frames;
      } else if (slice.samples_per_pixel != 1) {
        ++found.colours;
      } else if (!slice.position) {
        ++found.unplaced;
      } else {
        add_to_groups(found.groups, slice);
      }
    }
  }
  return found;
}

bool has_doubles(const Slices& slices) {
  std::vector<double> along;
  const Vector3d normal = slices.front().normal();
  for (const auto& s : slices) along.push_back(normal.dot(*s.position));
  std::ranges::sort(along);
  return std::ranges::adjacent_find(along, [](double a, double b) { return b - a < 1e-3; }) != along.end();
}

// A series may hold several volumes (phases, echoes): parted by the first attribute that leaves no position
// twice.
std::vector<Slices> part_series(Slices slices) {
  std::map<std::string, Slices> by_instance;  // exact copies are no second volume
  for (auto& s : slices) by_instance[s.instance_uid.empty() ? s.path : s.instance_uid].push_back(s);
  Slices once;
  for (const auto& [uid, same] : by_instance) once.push_back(same.front());
  if (!has_doubles(once)) return {std::move(slices)};
  for (const auto attribute : {&DicomSlice::acquisition, &DicomSlice::temporal_position, &DicomSlice::echo,
                               &DicomSlice::image_type}) {
    std::map<std::string, Slices> volumes;
    for (const auto& s : once) volumes[s.*attribute].push_back(s);
    if (volumes.size() < 2 ||
        std::ranges::any_of(volumes, [](const auto& v) { return has_doubles(v.second); }))
      continue;
    std::vector<Slices> parted;
    for (auto& [value, volume] : volumes) parted.push_back(std::move(volume));
    return parted;
  }
  return {std::move(slices)};
}

std::string described(const Slices& slices) {
  const DicomSlice& s = slices.front();
  return fmt::format("{} '{}' ({} slices of {} x {})", s.modality, s.series_description, slices.size(),
                     s.columns, s.rows);
}

std::size_t voxels(const Slices& slices) {
  return slices.size() * static_cast<std::size_t>(slices.front().columns) *
         static_cast<std::size_t>(slices.front().rows);
}

Result<Slices> choose(const std::string& folder, const Found& found, std::vector<std::string>& notes) {
  std::vector<Slices> volumes;
  for (const auto& group : found.groups)
    for (auto& volume : part_series(group)) volumes.push_back(std::move(volume));
  if (volumes.empty()) {
    if (found.frames)
      return failure(folder,
                     "holds multi-frame DICOM (all slices in one file) that does not say where each frame "
                     "lies; export it as one "
                     "file per slice, or as .nii.gz");
    if (found.segmentations)
      return bad_use(
          folder,
          "holds a DICOM segmentation and no scan; give it with --labels, and its scan as the volume");
    if (found.colours) return failure(folder, "holds only colour pictures; a CT or MR series is needed");
    if (found.unplaced)
      return failure(folder,
                     "holds DICOM pictures without position, orientation or pixel spacing that makes sense; "
                     "a CT or MR series is needed");
    return bad_use(folder, "holds no DICOM images");
  }
  const auto rank = [](const Slices& s) { return std::pair(s.front().modality == "CT", voxels(s)); };
  std::ranges::stable_sort(volumes, [&](const Slices& a, const Slices& b) { return rank(a) > rank(b); });
  if (volumes.size() > 1) {
    std::string others;
    for (std::size_t n = 1; n < volumes.size() && n < 4; ++n)
      others += (n > 1 ? ", " : "") + described(volumes[n]);
    if (volumes.size() > 4) others += fmt::format(" and {} more", volumes.size() - 4);
    notes.push_back(fmt::format("of {} series the largest{} was taken, {}; left aside: {}", volumes.size(),
                                volumes.front().front().modality == "CT" ? " CT" : "",
                                described(volumes.front()), others));
  }
  return volumes.front();
}

Result<FileQuantity> quantity_of(const std::string& folder, const std::string& modality,
                                 std::optional<FileQuantity> asked) {
  const bool ct = modality == "CT", mr = modality == "MR";
  if (!ct && !mr) {
    if (asked) return *asked;
    return bad_use(
        folder,
        fmt::format(
            "holds a series of modality '{}', which does not say what its values mean; say --quantity",
            modality));
  }
  const FileQuantity own = ct ? FileQuantity::hu : FileQuantity::mr;
  if (asked && *asked != own)
    return bad_use(folder, fmt::format("is a DICOM {} series, so its values are '{}', not '{}'", modality,
                                       quantity_name(own), quantity_name(*asked)));
  return own;
}

// Padding is what lies outside the round picture: from the ends of each row inwards. (A value inside may be
// padding's by chance: where it is 0, it is also water's.)
void blank_padding(std::span<float> row, float padding, float blank) {
  std::size_t first = 0, last = row.size();
  while (first < last && row[first] == padding) row[first++] = blank;
  while (last > first && row[last - 1] == padding) row[--last] = blank;
}

// One scaling and 16 bits for all slices: voxels stay as stored. Else they are scaled one by one, as float32.
bool uniform(const Slices& slices) {
  return std::ranges::all_of(slices, [&](const DicomSlice& s) {
    const DicomSlice& f = slices.front();
    const bool odd_padding = s.padding && s.slope * *s.padding + s.intercept > -1000;
    return s.slope == f.slope && s.intercept == f.intercept && s.pixels.is_signed == f.pixels.is_signed &&
           s.pixels.bits_allocated <= 16 && !(odd_padding && s.modality == "CT");
  });
}

// One slice of `all`, scaled unless all slices stay as stored.
Result<void> load_slice(const DicomSlice& slice, std::size_t k, StoredVoxels& all) {
  const auto width = static_cast<std::size_t>(slice.columns);
  const std::size_t area = width * static_cast<std::size_t>(slice.rows);
  if (all.scalar != Scalar::f32)  // two's complement: the low 16 bits are the value in either type
    return read_dicom_pixels(slice, std::span(all.storage).subspan(k * area, area));
  std::vector<std::int32_t> pixels(area);
  if (auto read = read_dicom_pixels(slice, std::span(pixels)); !read) return read;
  std::vector<float> values(area);
  for (std::size_t n = 0; n < area; ++n)
    values[n] = static_cast<float>(slice.slope * pixels[n] + slice.intercept);
  if (slice.padding && slice.modality == "CT")
    for (std::size_t row = 0; row < area; row += width)
      blank_padding(std::span(values).subspan(row, width),
                    static_cast<float>(slice.slope * *slice.padding + slice.intercept), padding_hu);
  std::memcpy(all.storage.data() + 2 * k * area, values.data(), area * sizeof(float));
  return {};
}

// Each thread reads and unpacks slices of its own, so that one reads while another unpacks.
Result<StoredVoxels> load(const Slices& slices, const Progress& progress) {
  const DicomSlice& first = slices.front();
  const std::size_t area = static_cast<std::size_t>(first.columns) * static_cast<std::size_t>(first.rows);
  StoredVoxels all{!uniform(slices)         ? Scalar::f32
                   : first.pixels.is_signed ? Scalar::i16
                                            : Scalar::u16,
                   area * slices.size(),
                   {}};
  all.storage.resize(all.count * scalar_bytes(all.scalar) / 2);
  std::vector<Result<void>> done(slices.size());
  in_slabs(std::ssize(slices), 0, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t k = from; k < to; ++k) {
      const auto n = static_cast<std::size_t>(k);
      try {
        done[n] = load_slice(slices[n], n, all);
      } catch (const std::bad_alloc&) {  // of which file
        done[n] = failure(slices[n].path, "does not fit into memory");
      }
      if (!done[n]) return;
      // by the thread that called, of its own share
      if (from == 0 && progress) progress(0.1 + 0.9 * static_cast<double>(k + 1) / static_cast<double>(to));
    }
  });
  for (const auto& slice : done)
    if (!slice) return tl::unexpected(slice.error());
  return all;
}

// slices between slices, linear along the stack's own step (so a tilt is followed)
std::vector<std::int16_t> interpolate(const std::vector<std::int16_t>& from, const SliceStack& stack) {
  const std::size_t area = static_cast<std::size_t>(stack.grid.size[0] * stack.grid.size[1]);
  std::vector<std::int16_t> to(stack.grid.count());
  for (std::size_t k = 0; k < stack.sources.size(); ++k) {
    const std::size_t below = std::min(static_cast<std::size_t>(stack.sources[k]), stack.slices.size() - 2);
    const double weight = std::clamp(stack.sources[k] - static_cast<double>(below), 0.0, 1.0);
    const auto *a = from.data() + below * area, *b = a + area;
    for (std::size_t n = 0; n < area; ++n)
      to[k * area + n] = static_cast<std::int16_t>(std::lrint((1 - weight) * a[n] + weight * b[n]));
  }
  return to;
}

// how the patient lay: the code's last letters, after head or feet first
std::string pose_of(std::string_view patient_position) {
  if (patient_position.size() < 3) return "";
  const auto way = patient_position.substr(2);
  if (way == "S") return "supine";
  if (way == "P") return "prone";
  if (way == "DL") return "on the left side";
  if (way == "DR") return "on the right side";
  return "";
}

ScannedVolume describe(const SliceStack& stack, const QuantityReading& reading) {
  const DicomSlice& first = stack.slices.front();
  ScannedVolume scanned;
  scanned.format = fmt::format("DICOM, {} slices{}", stack.slices.size(),
                               first.packing.empty() ? "" : ", packed as " + first.packing);
  scanned.series_description = first.series_description;
  scanned.modality = first.modality;
  scanned.pose = pose_of(first.patient_position);
  scanned.reading = reading.statement;
  scanned.volume.grid = stack.grid;
  scanned.volume.quantity = held_as(reading.quantity);
  if (first.modality == "CT" && !first.rescale_type.empty() && first.rescale_type != "HU")
    scanned.warnings.push_back("the series calls its values '" + first.rescale_type +
                               "', not 'HU'; they were taken as Hounsfield units");
  return scanned;
}

}  // namespace

Result<ScannedVolume> read_dicom_folder(const std::string& folder, const ReadOptions& options) try {
  const auto found = find_groups(folder, options.progress);
  if (!found) return tl::unexpected(found.error());
  std::vector<std::string> notes;
  auto chosen = choose(folder, *found, notes);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto stack = stack_slices(folder, std::move(*chosen));
  if (!stack) return tl::unexpected(stack.error());
  const DicomSlice& first = stack->slices.front();
  const auto quantity = quantity_of(folder, first.modality, options.quantity);
  if (!quantity) return tl::unexpected(quantity.error());

  auto voxels = load(stack->slices, options.progress);
  if (!voxels) return tl::unexpected(voxels.error());
  const bool scaled = voxels->scalar == Scalar::f32;
  const double slope = scaled ? 1 : first.slope, intercept = scaled ? 0 : first.intercept;
  const ValueRange range = value_range(*voxels, slope, intercept);
  auto reading = decide_quantity(folder, *voxels, slope, intercept, range, *quantity, "");
  if (!reading) return tl::unexpected(reading.error());
  if (!options.quantity)
    reading->statement = fmt::format("{}: the series is DICOM {}", quantity_words(*quantity), first.modality);

  ScannedVolume scanned = describe(*stack, *reading);
  scanned.warnings.insert(scanned.warnings.end(), notes.begin(), notes.end());
  scanned.warnings.insert(scanned.warnings.end(), stack->notes.begin(), stack->notes.end());
  scanned.volume.voxels = to_int16(std::move(*voxels), slope, intercept, range, *quantity, scanned.warnings);
  if (!stack->sources.empty()) scanned.volume.voxels = interpolate(scanned.volume.voxels, *stack);
  return scanned;
} catch (const std::bad_alloc&) {
  return failure(folder, "holds a series that does not fit into memory");
}

}  // namespace borelli
