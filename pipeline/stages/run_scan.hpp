// Stages of a run on the scan: its parts and their inertia.
#pragma once

#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/stages.hpp"

namespace borelli {

/// Finds the parts; writes segmentation/. Like all stages, returns its entry for run.json.
Result<nlohmann::json> segment_scan(RunData& data, const StageProgress& progress);

/// Uses the user's label map of parts instead of a segmentation. Errors: its grid is not the scan's.
Result<nlohmann::json> use_given_labels(RunData& data, const StageProgress& progress);

/// Writes inertia/table.csv and table.json.
Result<nlohmann::json> integrate_parts(RunData& data);

}  // namespace borelli
