// The stages of a run that look at the scan: its parts, and what they weigh.
#pragma once

#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/stages.hpp"

namespace borelli {

/// Finds the parts; leaves segmentation/. Answers what run.json is to say, as all stages do.
Result<nlohmann::json> segment_scan(RunData& data, const StageProgress& progress);

/// The user's own label map of parts in place of those found. Errors: it lies on another grid than the scan.
Result<nlohmann::json> use_given_labels(RunData& data, const StageProgress& progress);

/// Leaves inertia/table.csv and table.json.
Result<nlohmann::json> integrate_parts(RunData& data);

}  // namespace borelli
