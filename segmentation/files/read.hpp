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
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct ReadOptions {
  std::optional<FileQuantity> quantity;  ///< what the voxels hold, where the user says so
  Progress progress;                     ///< share of the file read, 0 to 1
};

/// A volume, and what its file said of it. Nothing here names the patient.
struct ScannedVolume {
  GreyVolume volume;
  std::string format;                 ///< e.g. "NIfTI-1, int16" or "DICOM, 160 slices"
  std::string series_description;     ///< DICOM only; else the file's own free text
  std::string modality;               ///< DICOM only: "CT", "MR", ...
  std::string pose;                   ///< DICOM only: "supine", "prone" ..., or empty where it is not said
  std::string sex;                    ///< DICOM only: "male", "female", or empty where it is neither
  std::optional<double> age_years;    ///< DICOM only: as the header states it
  std::string reading;                ///< what the voxels hold and why they were taken as that
  double least = 0, greatest = 0;     ///< values as stored in `volume`
  Clamped clamped;                    ///< numbers of voxels whose values did not fit
  std::vector<std::string> warnings;  ///< what was chosen, mended or left aside, one sentence each
};

/// Reads a folder of DICOM slices or one file (.nii, .nii.gz, .hdr or .img, .nrrd, .nhdr, .mha, .mhd). Values
/// as int16: hu clamped from below at -1024 but for padding (padding_hu), g/cm3 scaled to kg/m3. Errors:
/// missing or damaged file, more than one volume in it, colours, a quantity that is not given and that the
/// values do not tell.
Result<ScannedVolume> read_volume(const std::string& path, const ReadOptions& options = {});

/// Reads a label map and its names from a TSV (header "label<TAB>name"; where `names` is empty, the file of
/// the same name ending in .tsv, if there is one). Names of parts.hpp get the label they have there, other
/// labels the numbers from 17 on; without any such name the numbers stay, where they are at most 255. Values
/// that floating point or a scale moved off whole numbers are rounded. With `scan`, the labels are returned
/// on that grid; the file may cover a part of it or store its axes in another order. Doubts go to the map's
/// `warnings`. Errors: as read_volume; values that are not whole numbers from 0; more than 255 labels; a
/// damaged TSV; voxels that do not lie on the scan's (checked before any is read).
Result<LabelMap> read_labels(const std::string& path, const std::string& names = "",
                             const Progress& progress = {}, const Grid* scan = nullptr);

/// A label map whose names are not taken for parts, with the file's own numbers and names.
struct NumberedLabels {
  LabelMap map;                       ///< names[label] is empty where the file has none
  std::vector<std::int64_t> numbers;  ///< numbers[label]: what stands in the file for it
  /// By label: what else the file calls a class, likeliest first: its coded terminology, its ID.
  std::map<std::uint8_t, std::vector<std::string>> other_names;
};

/// The same file as somebody else's classes, see class_labels.hpp. Errors: as read_labels.
Result<NumberedLabels> read_numbered_labels(const std::string& path, const std::string& names = "",
                                            const Progress& progress = {});

/// The TSV that belongs to a label map: its name with the extension replaced by .tsv.
std::string names_file(const std::string& path);

}  // namespace borelli
