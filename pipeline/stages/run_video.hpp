// The stage of a run that films the moving body.
#pragma once

#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/stages.hpp"

namespace borelli {

/// Writes the video that the settings name: of the skin if it was asked for, else of the parts; with measured
/// ground forces as arrows. Errors: those of write_video.
Result<nlohmann::json> make_video(RunData& data, const StageProgress& progress);

}  // namespace borelli
