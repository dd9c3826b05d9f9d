// Files that segmentation writes to a run's folder, and their readers.
//
//   labels.nii.gz, labels.tsv   part numbers on the scan's grid, and their names
//   labels.ctbl                 their colours, for 3D Slicer
//   parts.nii.gz, .tsv, .ctbl   only if segments were requested (segments.hpp): all parts, the source of
//                               labels.nii.gz; the table needs the neighbours of each segment
//   landmarks.json              joint centres and bony points (segmentation/files/landmarks_file.hpp)
//   landmarks.mrk.json          the same as points for 3D Slicer, to be corrected by hand and given back
//   labels.dcm                  only if asked for: the same labels as a DICOM segmentation
//   segmentation.json           the verdict with its reasons; coverage, confidence and note of each requested
//                               part; warnings; parts declared absent; how the file was read
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "segmentation/files/dicom_source.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// The account as written to segmentation.json. `reading`: how the voxels were interpreted, and why.
nlohmann::json segmentation_account(const Segmentation& segmentation, const std::string& input,
                                    const std::string& reading);

/// Files of write_segmentation, and the additional ones if segments were requested.
inline constexpr std::array segmentation_file_names{"labels.tsv",         "labels.ctbl",
                                                    "labels.nii.gz",      "landmarks.json",
                                                    "landmarks.mrk.json", "segmentation.json"};
inline constexpr std::array all_parts_file_names{"parts.nii.gz", "parts.tsv", "parts.ctbl"};

/// Writes a label map, its names (TSV) and its colours (colour_table.hpp), all or none: first into a
/// temporary folder, then moved to `path` and beside it. Errors: as write_labels.
Result<void> write_label_files(const std::filesystem::path& path, const LabelMap& labels);

/// Writes a label map as a DICOM segmentation that refers to `source` (null: to no scan). `patient`: whom it
/// shows, too. Errors: as write_dicom_labels.
Result<void> write_dicom_label_file(const std::filesystem::path& path, const LabelMap& labels,
                                    const DicomSource* source, bool patient);

/// For the help of --patient.
inline constexpr const char* patient_help =
    "Copy the patient's name, number, sex, age and the dates of the study from the scan into labels.dcm "
    "(default: empty)";

/// Writes these files into `folder` (created if missing), each under a temporary name and then renamed. Never
/// overwrites `given`, the user's landmark file (a path, or empty). Errors: as the writers.
Result<void> write_segmentation(const std::filesystem::path& folder, const Segmentation& segmentation,
                                const nlohmann::json& account, const std::string& given = "");

/// The convention that cut the parts, from segmentation.json; empty if an older file does not state it.
/// Errors: no such file, a convention that is not text.
Result<std::string> read_convention(const std::filesystem::path& path);

/// The warnings in segmentation.json; none if it is damaged. Errors: no such file.
Result<std::vector<Warning>> read_warnings(const std::filesystem::path& path);

/// The verdict in segmentation.json, in the words of in_words (segmentation/labelling/verdict.hpp); empty if
/// an older file has none. Errors: no such file.
Result<std::string> read_verdict(const std::filesystem::path& path);

/// Parts that segmentation.json lists as declared absent. Errors: no such file, a name that is not a part.
Result<AbsentParts> read_absent(const std::filesystem::path& path);

/// The parts' findings from segmentation.json. Errors: missing or damaged file, an unknown part or coverage.
Result<std::array<PartFinding, parts.size()>> read_findings(const std::filesystem::path& path);

}  // namespace borelli
