// What verbs that look at a scene at one state share: the scene, laid out, and the state from its file.
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
  FileOrder order;  ///< the file's, which lists in JSON have
  State state;
  Eigen::VectorXd efforts;  ///< nv, given beside the scene's own
};

/// Reads the scene, and the state: {"t": 0, "q": [...], "v": [...], "efforts": [...]}, or without a state
/// file the scene's initial one. What is wrong is told with the file that it is in.
Result<SceneAtState> read_scene_at_state(const StateOptions& options, const Command& command);

/// An error of the engine with the scene's file before it.
tl::unexpected<Error> in_scene(const StateOptions& options, Error error);

/// The answer, or an error that names a number of it that is none, which JSON cannot hold: states and scenes
/// may be so far out that what is computed of them overflows.
Result<nlohmann::json> of_numbers(const StateOptions& options, nlohmann::json answer);

/// A state as --state reads it.
nlohmann::json json_of(const State& state, const FileOrder& order);

/// Rows over the coordinates, their columns in the file's order.
nlohmann::json rows_in_file_order(const Eigen::MatrixXd& rows, const FileOrder& order);

}  // namespace borelli
