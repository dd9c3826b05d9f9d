// The stage of a run that gives the body a captured motion.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/stages.hpp"

namespace borelli {

/// Whether the motion's file holds joint angles (.mot, .sto) instead of markers.
bool holds_angles(const CapturedSettings& settings);

/// Files that capture_motion writes.
std::vector<std::string> captured_outputs(const CapturedSettings& settings);

/// Fits the recording to the body (captured_motion.hpp) and writes its trajectory, angles, moments with their
/// deviations, powers and skeleton below motion/, and model/captured.toml, the body with the markers. From
/// markers also their paths and errors. Errors: those of reading and fitting; a label map whose body has no
/// landmarks.
Result<nlohmann::json> capture_motion(RunData& data, const StageProgress& progress);

}  // namespace borelli
