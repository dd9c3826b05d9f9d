// The stages of a run that make a body that moves, and what there is to see of it.
#pragma once

#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/stages.hpp"

namespace borelli {

/// Leaves model/scene.toml. Errors: no part that could move. Answers what run.json is to say, as all stages
/// do.
Result<nlohmann::json> build_scene(RunData& data);

/// Leaves model/smallest.toml, the smallest model that keeps to the tolerance (economy.hpp), and
/// model/economy.html. Errors: a motion that cannot be computed so well.
Result<nlohmann::json> find_smallest(RunData& data, const StageProgress& progress);

/// Leaves motion/trajectory.h5 and .csv. Errors: a motion whose certificate says untrusted.
Result<nlohmann::json> simulate_scene(RunData& data, const StageProgress& progress);

/// Leaves mesh/*.stl and *.vtp; with --deface without the face.
Result<nlohmann::json> make_meshes(RunData& data, const StageProgress& progress);

/// Leaves body.glb.
Result<nlohmann::json> make_glb(RunData& data);

/// Leaves body.png; without a display a warning.
Result<nlohmann::json> draw_picture(RunData& data);

/// Leaves no file: packs what the report shows of the scan (a report that finds it missing does so itself).
Result<nlohmann::json> pack_scan(RunData& data);

/// Leaves report.html; `record` is run.json as far as it stands.
Result<nlohmann::json> write_page(RunData& data, const nlohmann::json& record);

}  // namespace borelli
