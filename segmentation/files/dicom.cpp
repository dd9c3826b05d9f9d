#include "segmentation/files/dicom.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <set>

#include "process/memory.hpp"
#include "segmentation/files/dicom_elements.hpp"
#include "segmentation/files/dicom_files.hpp"
#include "segmentation/files/dicom_volumes.hpp"
#include "segmentation/files/header_text.hpp"
#include "segmentation/files/slice_stack.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Slices = std::vector<DicomSlice>;

struct Found {
  std::vector<Slices> groups;          // one series, size and orientation each
  std::vector<std::string> frames;     // multi-frame files without frame positions
  std::size_t segmentations = 0;       // DICOM-SEG objects, which are not scans
  std::vector<std::string> colours;    // images with several samples per pixel
  std::vector<std::string> unplaced;   // images without position
  std::vector<std::string> no_images;  // files that hold no DICOM image
  Placeholders placeholders;
};

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
  const auto below = files_below(folder);
  if (!below) return tl::unexpected(below.error());
  const auto& files = below->files;
  std::vector<Result<Slices>> headers(files.size());
  in_slabs(std::ssize(headers), 0, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t k = from; k < to; ++k) {
      const auto n = static_cast<std::size_t>(k);
      headers[n] = read_dicom_slices(files[n]);
      // headers take a tenth of the progress bar; only the calling thread reports
      if (from == 0 && progress) progress(0.1 * static_cast<double>(k + 1) / static_cast<double>(to));
    }
  });
  Found found;
  found.placeholders = below->placeholders;
  for (std::size_t n = 0; n < files.size(); ++n) {
    const Result<Slices>& slices = headers[n];
    if ((!slices || slices->empty()) && found.placeholders.add_if_placeholder(files[n])) continue;
    if (!slices) return tl::unexpected(slices.error());
    if (slices->empty()) found.no_images.push_back(files[n]);
    for (const DicomSlice& slice : *slices) {
      if (slice.modality == "SEG") {
        ++found.segmentations;
        break;
      } else if (slice.modality == "RTDOSE") {  // with or without pixels
        found.no_images.push_back(files[n]);
        break;
      } else if (slice.frames > 1) {
        found.frames.push_back(files[n]);
      } else if (slice.samples_per_pixel != 1) {
        found.colours.push_back(files[n]);
      } else if (!slice.position) {
        found.unplaced.push_back(files[n]);
      } else {
        add_to_groups(found.groups, slice);
      }
    }
  }
  return found;
}

std::string described(const DicomVolume& volume) {
  const DicomSlice& s = volume.slices.front();
  return fmt::format("{} '{}'{} ({} slices of {} x {})", s.modality, s.series_description,
                     volume.part.empty() ? "" : ", " + volume.part, volume.slices.size(), s.columns, s.rows);
}

double voxels(const Slices& slices) {
  return static_cast<double>(slices.size()) * slices.front().columns * slices.front().rows;
}

Error nothing_to_read(const std::string& folder, const Found& found) {
  const auto refusal = [&]() -> Result<void> {
    if (!found.frames.empty())
      return failure(folder,
                     "contains multi-frame DICOM (all slices in one file) that does not say where each frame "
                     "lies; export it as one file per slice, or as .nii.gz");
    if (found.segmentations)
      return bad_use(folder,
                     "contains a DICOM segmentation but no scan; give the scan as the volume, and the "
                     "segmentation with --labels");
    if (!found.colours.empty())
      return failure(folder, "contains only colour pictures; give a CT or MR series");
    if (!found.unplaced.empty())
      return failure(folder,
                     "contains DICOM pictures that do not state position, orientation and pixel spacing; "
                     "give a CT or MR series");
    std::set<std::string> kinds;
    for (const std::string& file : found.no_images)
      if (const auto object = read_dicom_elements(file); object && *object)
        kinds.insert(kind_without_series(**object));
    if (!kinds.empty())
      return bad_use(folder, fmt::format("contains no series of images, but {}; give a CT or MR series",
                                         fmt::join(kinds, ", ")));
    return bad_use(folder, "contains no DICOM images");
  };
  Error error = refusal().error();
  for (const auto& sentence : found.placeholders.sentences()) error.what += "; " + sentence;
  return error;
}

// One sentence per kind of image that was left out. Files that hold no image count if they are named like the
// slices of `volume`, as damaged slices are.
std::vector<std::string> left_out(const Found& found, const DicomVolume& volume) {
  std::set<std::string> endings;
  for (const DicomSlice& slice : volume.slices)
    endings.insert(lower_case(std::filesystem::path(slice.path).extension().string()));
  // also packed ones, as a.dcm.gz
  const auto is_like_slices = [&](const std::filesystem::path& path) {
    const std::string name = lower_case(path.filename().string());
    return name != "dicomdir" && std::ranges::any_of(endings, [&](const std::string& ending) {
             return ending.empty() ? !path.has_extension() : name.find(ending) != std::string::npos;
           });
  };
  std::vector<std::string> damaged;
  std::ranges::copy_if(found.no_images, std::back_inserter(damaged), is_like_slices);
  std::vector<std::string> out;
  const auto add = [&](std::vector<std::string> files, const char* one, const char* many) {
    files.erase(std::unique(files.begin(), files.end()), files.end());
    if (!files.empty()) out.push_back(files_sentence(files, one, many));
  };
  add(found.unplaced, "does not state its position, orientation and pixel spacing",
      "do not state their position, orientation and pixel spacing");
  add(found.colours, "is a colour picture", "are colour pictures");
  add(found.frames, "holds several frames without their positions",
      "hold several frames without their positions");
  add(damaged, "holds no DICOM image", "hold no DICOM image");
  return out;
}

Result<DicomVolume> choose(const std::string& folder, Found found) {
  if (found.groups.empty()) return tl::unexpected(nothing_to_read(folder, found));
  auto read = volumes_of(std::move(found.groups));
  if (!read) return tl::unexpected(read.error());
  auto& volumes = *read;
  const auto rank = [](const DicomVolume& v) {
    return std::pair(v.slices.front().modality == "CT", voxels(v.slices));
  };
  std::ranges::stable_sort(volumes,
                           [&](const DicomVolume& a, const DicomVolume& b) { return rank(a) > rank(b); });
  DicomVolume chosen = std::move(volumes.front());
  if (volumes.size() > 1) {
    std::string others;
    bool one_series = true;
    for (std::size_t n = 1; n < volumes.size(); ++n) {
      if (n < 4) others += (n > 1 ? ", " : "") + described(volumes[n]);
      one_series = one_series && volumes[n].slices.front().series_uid == chosen.slices.front().series_uid;
    }
    if (volumes.size() > 4) others += fmt::format(" and {} more", volumes.size() - 4);
    chosen.notes.insert(
        chosen.notes.begin(),
        fmt::format("found {} {}; read the largest{}, {}; ignored: {}", volumes.size(),
                    one_series ? "volumes of one series" : "series",
                    chosen.slices.front().modality == "CT" ? " CT" : "", described(chosen), others));
  }
  for (const auto& sentences : {found.placeholders.sentences(), left_out(found, chosen)})
    for (const auto& sentence : sentences) chosen.notes.push_back(sentence + "; ignored");
  return chosen;
}

// Errors: slices of a CT series without the scaling that the others have.
Result<void> check_scaling(const std::string& folder, const Slices& slices) {
  if (slices.front().modality != "CT") return {};
  const auto bare = std::ranges::count_if(slices, [](const DicomSlice& s) { return !s.is_scaled; });
  if (bare > 0 && bare < std::ssize(slices))
    return failure(folder,
                   fmt::format("lacks RescaleSlope and RescaleIntercept in {} of its {} slices, so their "
                               "CT numbers are unknown; add them or leave these slices out",
                               bare, slices.size()));
  return {};
}

// Errors: values beyond the range of CT numbers where some slices are declared signed and some unsigned.
Result<void> check_signs(const std::string& folder, const Slices& slices, const Clamped& clamped) {
  const auto is_signed =
      std::ranges::count_if(slices, [](const DicomSlice& s) { return s.pixels.is_signed; });
  if (slices.front().modality != "CT" || clamped.above == 0 || is_signed == 0 ||
      is_signed == std::ssize(slices))
    return {};
  return failure(folder,
                 fmt::format("declares {} of its {} slices as signed and the others as unsigned, and has "
                             "values above 32767; correct PixelRepresentation",
                             is_signed, slices.size()));
}

Result<FileQuantity> quantity_of(const std::string& folder, const std::string& modality,
                                 std::optional<FileQuantity> asked) {
  const bool ct = modality == "CT", mr = modality == "MR";
  if (!ct && !mr) {
    if (asked) return *asked;
    return bad_use(
        folder,
        fmt::format(
            "contains a series of modality '{}', which does not say what its values mean; give --quantity",
            modality));
  }
  const FileQuantity own = ct ? FileQuantity::hu : FileQuantity::mr;
  if (asked && *asked != own)
    return bad_use(folder,
                   fmt::format("is a DICOM {} series, so its values are '{}', not '{}'; correct --quantity",
                               modality, quantity_name(own), quantity_name(*asked)));
  return own;
}

// Padding lies outside the round field of view: from the ends of each row inwards. (A measured value inside
// may equal the padding value: 0 is also water's.)
void blank_padding(std::span<float> row, float padding, float blank) {
  std::size_t first = 0, last = row.size();
  while (first < last && row[first] == padding) row[first++] = blank;
  while (last > first && row[last - 1] == padding) row[--last] = blank;
}

// Whether all slices share one scaling and 16 bits: voxels then stay as stored. Else they are scaled slice by
// slice, as float32.
bool uniform(const Slices& slices) {
  return std::ranges::all_of(slices, [&](const DicomSlice& s) {
    const DicomSlice& f = slices.front();
    const bool odd_padding = s.padding && s.slope * *s.padding + s.intercept > -1000;
    return s.slope == f.slope && s.intercept == f.intercept && s.pixels.is_signed == f.pixels.is_signed &&
           s.pixels.bits_allocated <= 16 && !(odd_padding && s.modality == "CT");
  });
}

// Loads slices [from, to) into `all`, rescaled unless all slices stay as stored. `done` gets the number
// loaded so far.
Result<void> load_slices(std::span<const DicomSlice> slices, std::size_t from, std::size_t to,
                         StoredVoxels& all, const std::function<void(std::size_t)>& done) {
  const auto width = static_cast<std::size_t>(slices.front().columns);
  const std::size_t area = width * static_cast<std::size_t>(slices.front().rows);
  const auto own = slices.subspan(from, to - from);
  if (all.scalar != Scalar::f32)  // two's complement: the low 16 bits are the value in either type
    return read_dicom_pixels(own, std::span(all.storage).subspan(from * area, own.size() * area), done);
  constexpr std::size_t at_once = 8;
  std::vector<std::int32_t> pixels(std::min(at_once, own.size()) * area);
  std::vector<float> values(area);
  for (std::size_t first = 0; first < own.size(); first += at_once) {
    const auto some = own.subspan(first, std::min(at_once, own.size() - first));
    if (const auto read = read_dicom_pixels(some, std::span(pixels).first(some.size() * area)); !read)
      return read;
    for (std::size_t k = 0; k < some.size(); ++k) {
      const DicomSlice& slice = some[k];
      for (std::size_t n = 0; n < area; ++n)
        values[n] = static_cast<float>(slice.slope * pixels[k * area + n] + slice.intercept);
      if (slice.padding && slice.modality == "CT")
        for (std::size_t row = 0; row < area; row += width)
          blank_padding(std::span(values).subspan(row, width),
                        static_cast<float>(slice.slope * *slice.padding + slice.intercept), padding_hu);
      std::memcpy(all.storage.data() + 2 * (from + first + k) * area, values.data(), area * sizeof(float));
    }
    if (done) done(first + some.size());
  }
  return {};
}

// Each thread reads and unpacks its own slices, so that one reads while another unpacks.
Result<StoredVoxels> load(const std::string& folder, const Slices& slices, const Progress& progress) {
  const DicomSlice& first = slices.front();
  for (const DicomSlice& slice : slices)
    if (const auto whole = check_pixels(slice); !whole) return tl::unexpected(whole.error());
  StoredVoxels all{!uniform(slices)         ? Scalar::f32
                   : first.pixels.is_signed ? Scalar::i16
                                            : Scalar::u16,
                   static_cast<std::size_t>(voxels(slices)),
                   {}};
  if (const auto fits = admit_memory(
          folder, fmt::format("the series ({} slices of {} x {})", slices.size(), first.columns, first.rows),
          voxels(slices) * static_cast<double>(scalar_bytes(all.scalar)));
      !fits)
    return tl::unexpected(fits.error());
  all.storage.resize(all.count * scalar_bytes(all.scalar) / 2);
  std::vector<Result<void>> read(slices.size());  // each share's result, at its first slice
  in_slabs(std::ssize(slices), 0, [&](std::int64_t from, std::int64_t to) {
    // only the calling thread reports, for its own share
    const auto done = [&](std::size_t count) {
      if (from == 0 && progress) progress(0.1 + 0.9 * static_cast<double>(count) / static_cast<double>(to));
    };
    const auto n = static_cast<std::size_t>(from);
    if (from == to) return;
    try {
      read[n] = load_slices(slices, n, static_cast<std::size_t>(to), all, done);
    } catch (const std::bad_alloc&) {  // name the file
      read[n] = failure(slices[n].path, "does not fit into memory");
    }
  });
  for (const auto& share : read)
    if (!share) return tl::unexpected(share.error());
  return all;
}

// linear interpolation between slices along the stack's own step, so that a tilt is followed
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

// the patient's pose: the code's last letters, after head or feet first
std::string pose_of(std::string_view patient_position) {
  if (patient_position.size() < 3) return "";
  const auto posture = patient_position.substr(2);
  if (posture == "S") return "supine";
  if (posture == "P") return "prone";
  if (posture == "DL") return "on the left side";
  if (posture == "DR") return "on the right side";
  return "";
}

std::string sex_of(std::string_view code) {
  const std::string word = lower_case(trimmed(code));
  if (word == "m" || word == "male") return "male";
  if (word == "f" || word == "female") return "female";
  return "";
}

// An age string (PS3.5, 6.2): three digits and its unit, of days, weeks, months or years. Some writers leave
// zeros or the unit out.
std::optional<double> age_of(std::string_view code) {
  const std::string word = lower_case(trimmed(code));
  const auto digits = std::min(word.find_first_not_of("0123456789"), word.size());
  if (digits == 0 || digits > 3 || word.size() > digits + 1) return std::nullopt;
  const double number = std::stod(word.substr(0, digits));
  const char unit = word.size() > digits ? word[digits] : 'y';
  const double in_a_year = unit == 'y'   ? 1
                           : unit == 'm' ? 12
                           : unit == 'w' ? 52.18
                           : unit == 'd' ? 365.25
                                         : 0;
  if (in_a_year == 0 || number / in_a_year > 120) return std::nullopt;
  return number / in_a_year;
}

ScannedVolume describe(const SliceStack& stack, const QuantityReading& reading) {
  const DicomSlice& first = stack.slices.front();
  ScannedVolume scanned;
  scanned.format = fmt::format("DICOM, {} slices{}", stack.slices.size(),
                               first.packing.empty() ? "" : ", packed as " + first.packing);
  scanned.series_description = first.series_description;
  scanned.modality = first.modality;
  scanned.pose = pose_of(first.patient_position);
  scanned.sex = sex_of(first.patient_sex);
  scanned.age_years = age_of(first.patient_age);
  scanned.reading = reading.statement;
  scanned.volume.grid = stack.grid;
  scanned.volume.quantity = held_as(reading.quantity);
  if (first.modality == "CT" && !first.rescale_type.empty() && first.rescale_type != "HU")
    scanned.warnings.push_back("the series calls its values '" + first.rescale_type +
                               "', not 'HU'; they were read as Hounsfield units");
  return scanned;
}

}  // namespace

Result<SliceStack> find_dicom_stack(const std::string& folder, const Progress& progress) {
  auto found = find_groups(folder, progress);
  if (!found) return tl::unexpected(found.error());
  auto chosen = choose(folder, std::move(*found));
  if (!chosen) return tl::unexpected(chosen.error());
  auto stack = stack_slices(folder, std::move(chosen->slices));
  if (stack) stack->notes.insert(stack->notes.begin(), chosen->notes.begin(), chosen->notes.end());
  return stack;
}

Result<ScannedVolume> read_dicom_folder(const std::string& folder, const ReadOptions& options) try {
  const auto stack = find_dicom_stack(folder, options.progress);
  if (!stack) return tl::unexpected(stack.error());
  const DicomSlice& first = stack->slices.front();
  const auto quantity = quantity_of(folder, first.modality, options.quantity);
  if (!quantity) return tl::unexpected(quantity.error());
  if (auto fine = check_scaling(folder, stack->slices); !fine) return tl::unexpected(fine.error());

  auto voxels = load(folder, stack->slices, options.progress);
  if (!voxels) return tl::unexpected(voxels.error());
  const bool scaled = voxels->scalar == Scalar::f32;
  const double slope = scaled ? 1 : first.slope, intercept = scaled ? 0 : first.intercept;
  const ValueRange range = value_range(*voxels, slope, intercept);
  auto reading = decide_quantity(folder, *voxels, slope, intercept, range, *quantity, "");
  if (!reading) return tl::unexpected(reading.error());
  if (!options.quantity)
    reading->statement = fmt::format("{}: the series is DICOM {}", quantity_words(*quantity), first.modality);

  ScannedVolume scanned = describe(*stack, *reading);
  scanned.warnings.insert(scanned.warnings.end(), stack->notes.begin(), stack->notes.end());
  scanned.volume.voxels =
      to_int16(std::move(*voxels), slope, intercept, range, *quantity, scanned.warnings, &scanned.clamped);
  if (auto fine = check_signs(folder, stack->slices, scanned.clamped); !fine)
    return tl::unexpected(fine.error());
  if (!stack->sources.empty()) {
    const auto fits =
        admit_memory(folder, fmt::format("its {} slices, resampled to even spacing,", stack->sources.size()),
                     2 * static_cast<double>(stack->grid.count()));
    if (!fits) return tl::unexpected(fits.error());
    scanned.volume.voxels = interpolate(scanned.volume.voxels, *stack);
  }
  return scanned;
} catch (const std::bad_alloc&) {
  return failure(folder, "contains a series that does not fit into memory; allow more with --max-memory");
}

}  // namespace borelli
