// Stages of a run that make the moving body and its views.
#pragma once

#include <nlohmann/json.hpp>

#include "error/error.hpp"
#include "pipeline/stages/run_data.hpp"
#include "pipeline/stages/stages.hpp"

namespace borelli {

/// Writes model/scene.toml. Errors: no part that could move. Like all stages, returns its entry for run.json.
Result<nlohmann::json> build_scene(RunData& data);

/// Writes model/smallest.toml, the smallest model within the tolerance (economy.hpp), and model/economy.html.
/// Errors: a motion that cannot be computed that accurately.
Result<nlohmann::json> find_smallest(RunData& data, const StageProgress& progress);

/// Writes motion/trajectory.h5 and .csv. Errors: a motion whose certificate says untrusted.
Result<nlohmann::json> simulate_scene(RunData& data, const StageProgress& progress);

/// Writes mesh/*.stl and *.vtp; with --deface without the face.
Result<nlohmann::json> make_meshes(RunData& data, const StageProgress& progress);

/// Writes model/body.osim and model/body.xml, with landmarks as markers, deviations as comments, and the
/// meshes of mesh/. "omissions" of the entry: what each cannot hold. A model that cannot hold the scene is
/// missing, with a warning.
Result<nlohmann::json> write_models(RunData& data);

/// Writes body.glb.
Result<nlohmann::json> make_glb(RunData& data);

/// Writes skin.glb.
Result<nlohmann::json> make_skin(RunData& data);

/// Writes body.png; only warns if the machine cannot draw.
Result<nlohmann::json> draw_picture(RunData& data);

/// Writes no file: prepares the report's views of the scan. The report prepares them itself if they are
/// missing.
Result<nlohmann::json> pack_scan(RunData& data);

/// Writes report.html; `record` is run.json so far.
Result<nlohmann::json> write_page(RunData& data, const nlohmann::json& record);

}  // namespace borelli
