// Reads a scan or a label map from disk: DICOM folders, NIfTI, NRRD and MetaImage.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/quantity.hpp"
#include "segmentation/files/segment_overlaps.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct ReadOptions {
  std::optional<FileQuantity> quantity;  ///< what the voxels hold, if the user says so
  Progress progress;                     ///< fraction of the file read, 0 to 1
};

/// A volume, and its file's metadata. Nothing here names the patient.
struct ScannedVolume {
  GreyVolume volume;
  std::string format;                 ///< e.g. "NIfTI-1, int16" or "DICOM, 160 slices"
  std::string series_description;     ///< DICOM only; else the file's own free text
  std::string modality;               ///< DICOM only: "CT", "MR", ...
  std::string pose;                   ///< DICOM only: "supine", "prone" ...; empty: not stated
  std::string sex;                    ///< DICOM only: "male", "female"; empty: neither
  std::optional<double> age_years;    ///< DICOM only: as the header states it
  std::string reading;                ///< what the voxels hold and why it was chosen
  double least = 0, greatest = 0;     ///< values as stored in `volume`
  Clamped clamped;                    ///< numbers of voxels whose values did not fit
  std::vector<std::string> warnings;  ///< what was chosen, corrected or ignored, one sentence each
};

/// Reads a folder of DICOM slices or one file (.nii, .nii.gz, .hdr or .img, .nrrd, .nhdr, .mha, .mhd). Values
/// as int16: hu clamped from below at -1024 except for padding (padding_hu), g/cm3 scaled to kg/m3. Errors:
/// missing or damaged file, more than one volume in it, colours, a quantity that is neither given nor clear
/// from the values.
Result<ScannedVolume> read_volume(const std::string& path, const ReadOptions& options = {});

/// Reads a label map and its names from a TSV (header "label<TAB>name"). If `names` is empty, the file of the
/// same name ending in .tsv is used if it exists (not beside DICOM, which names its segments). Names of
/// parts.hpp get the labels of parts.hpp, other names numbers from 17 on. Without any such name the file's
/// numbers stay if they are at most 255. Values that floating point or a scale factor moved off whole numbers
/// are rounded. With `scan`, the labels are returned on that grid; the file may cover a part of it, reach
/// beyond it (see `labelled` and `beyond` of the map) or store its axes in another order. Doubts go to the
/// map's `warnings`. Errors: as read_volume; values that are not whole numbers from 0; more than 255 labels;
/// a damaged TSV; voxels that do not coincide with the scan's (checked before any is read). Where segments
/// overlap, parts keep their voxels (segment_overlaps.hpp).
Result<LabelMap> read_labels(const std::string& path, const std::string& names = "",
                             const Progress& progress = {}, const Grid* scan = nullptr);

/// A label map whose names are not matched to parts, with the file's own numbers and names.
struct NumberedLabels {
  LabelMap map;                       ///< names[label] is empty if the file has none
  std::vector<std::int64_t> numbers;  ///< numbers[label]: its number in the file
  /// By label: other names of a class in the file, likeliest first: its coded terminology, its ID.
  std::map<std::uint8_t, std::vector<std::string>> other_names;
};

/// Reads the same file as another program's classes, see class_labels.hpp. `is_used` as for SegmentOverlaps.
/// Errors: as read_labels.
Result<NumberedLabels> read_numbered_labels(const std::string& path, const std::string& names = "",
                                            const Progress& progress = {}, const IsUsed& is_used = {});

/// The TSV that belongs to a label map: its name with the extension replaced by .tsv.
std::string names_file(const std::string& path);

}  // namespace borelli
