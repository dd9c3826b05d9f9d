// Shared by verbs that evaluate a scene at one state: reads the scene, compiles it, and reads the state's
// file.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/files/file_order.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {

/// The options of such a verb.
struct StateOptions {
  std::string scene, state;
  ModelOptions model;
  std::optional<std::string> equations;
};

/// Adds the scene, --state, --floating and --equations.
void add_state_options(CLI::App& verb, StateOptions& options);

/// A scene at a state.
struct SceneAtState {
  ModelFile model;
  System system;
  FileOrder order;  ///< the file's order, used by all lists in JSON
  State state;
  Eigen::VectorXd efforts;  ///< nv, applied in addition to the scene's own
};

/// Reads the scene and the state: {"t": 0, "q": [...], "v": [...], "efforts": [...]}; without a state file,
/// the scene's initial state. Errors name the file they are in.
Result<SceneAtState> read_scene_at_state(const StateOptions& options, const Command& command);

/// Returns the answer, or an error that names a non-finite number in it, which JSON cannot hold: extreme
/// states and scenes may overflow.
Result<nlohmann::json> of_numbers(const StateOptions& options, nlohmann::json answer);

/// A state in the form that --state reads.
nlohmann::json json_of(const State& state, const FileOrder& order);

/// Rows over the coordinates, with columns in the file's order.
nlohmann::json rows_in_file_order(const Eigen::MatrixXd& rows, const FileOrder& order);

}  // namespace borelli
