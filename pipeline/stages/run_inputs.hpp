// Files that a run reads, and their digests.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/files/input_names.hpp"
#include "pipeline/stages/run.hpp"

namespace borelli {

struct RunInput {
  std::string role;  ///< "volume", "labels", "label_names", "label_mapping", "landmarks", "motion", "forces",
                     ///< "static_trial" or "marker_map"
  std::vector<std::string> files;  ///< the user's file, then voxel files that its header names
};

/// The names of a run's inputs in its outputs.
InputNames input_names(const RunSettings& settings);

/// Whether an input is part of the captured motion: only the motion depends on it, not the body.
bool is_captured(const RunInput& input);

/// The files that a run reads. Reads the headers of volumes, which may name other files for the voxels (.mhd,
/// .nhdr, .hdr). Errors: those of read_image_header and check_input_file.
Result<std::vector<RunInput>> inputs_of(const RunSettings& settings);

/// {"volume": [{"file": name, "sha256": hex}, ...], ...}; digest_of digests a folder. Errors: not readable.
Result<nlohmann::json> digests_of(const std::vector<RunInput>& inputs, const InputNames& names);

}  // namespace borelli
