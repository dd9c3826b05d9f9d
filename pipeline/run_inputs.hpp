// The files that a run reads, and their digests.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/run.hpp"
#include "pipeline/stages/input_names.hpp"

namespace borelli {

struct RunInput {
  std::string role;                ///< "volume", "labels", "label_names", "label_mapping" or "landmarks"
  std::vector<std::string> files;  ///< the one that was named, and the one that its header names, if any
};

/// How what it reads is named in what it writes.
InputNames input_names(const RunSettings& settings);

/// Of volumes the headers are read, which say where the voxels are (.mhd, .nhdr). Errors: a file that is
/// missing; those of read_image_header.
Result<std::vector<RunInput>> inputs_of(const RunSettings& settings);

/// {"volume": [{"file": name, "sha256": hex}, ...], ...}, of a folder as digest_of. Errors: not readable.
Result<nlohmann::json> digests_of(const std::vector<RunInput>& inputs, const InputNames& names);

}  // namespace borelli
