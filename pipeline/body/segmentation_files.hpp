// What segmentation leaves in a run's folder, and how later stages read it.
//
//   labels.nii.gz, labels.tsv   part numbers on the scan's grid, and their names
//   labels.ctbl                 their colours, for 3D Slicer
//   parts.nii.gz, .tsv, .ctbl   where segments were asked for (segments.hpp): all parts, which labels.nii.gz
//                               was taken from; the table needs their neighbours
//   landmarks.json              joint centres and bony points (segmentation/files/landmarks_file.hpp)
//   landmarks.mrk.json          the same as points of 3D Slicer, for a person to mend and hand back
//   segmentation.json           the verdict with its reasons; per part asked for its coverage, confidence
//                               and note; warnings; the parts told to be absent; how the file was read
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// The account as written to segmentation.json. `reading`: what the voxels were taken for, and why.
nlohmann::json segmentation_account(const Segmentation& segmentation, const std::string& input,
                                    const std::string& reading);

/// The files that write_segmentation leaves, and those besides where segments were asked for.
inline constexpr std::array segmentation_file_names{"labels.tsv",         "labels.ctbl",
                                                    "labels.nii.gz",      "landmarks.json",
                                                    "landmarks.mrk.json", "segmentation.json"};
inline constexpr std::array all_parts_file_names{"parts.nii.gz", "parts.tsv", "parts.ctbl"};

/// A label map, its names (TSV) and its colours (colour_table.hpp), all whole or none: made in a folder
/// beside, then moved to `path` and beside it. Errors: as write_labels.
Result<void> write_label_files(const std::filesystem::path& path, const LabelMap& labels);

/// Writes these files into `folder` (made where missing), each beside and renamed; not over the landmarks
/// that were given (a file's path, or empty). Errors: as the writers.
Result<void> write_segmentation(const std::filesystem::path& folder, const Segmentation& segmentation,
                                const nlohmann::json& account, const std::string& given = "");

/// The convention by which the parts were cut, from segmentation.json; empty where an older file does not
/// say. Errors: no such file, a convention that is not text.
Result<std::string> read_convention(const std::filesystem::path& path);

/// The warnings in segmentation.json; none where it is damaged. Errors: no such file.
Result<std::vector<Warning>> read_warnings(const std::filesystem::path& path);

/// The verdict in segmentation.json as in_words (segmentation/labelling/verdict.hpp) says it; empty where an
/// older file has none. Errors: no such file.
Result<std::string> read_verdict(const std::filesystem::path& path);

/// The parts that segmentation.json says were told to be absent. Errors: no such file, a name that is no
/// part.
Result<AbsentParts> read_absent(const std::filesystem::path& path);

/// The parts' findings from segmentation.json. Errors: missing or damaged file, an unknown part or coverage.
Result<std::array<PartFinding, parts.size()>> read_findings(const std::filesystem::path& path);

}  // namespace borelli
