// What verbs that read a scene of any kind share: the options of reading, and what the file held beside the
// scene.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "dynamics/model_file.hpp"

namespace borelli {

/// Adds --floating, --lock and --minimum-mass.
void add_model_options(CLI::App& verb, ModelOptions& options);

/// Of ModelFile::not_modelled what does not change the motion, for people, a line each. (What does is warned
/// of by read_model of inputs.hpp.)
std::string not_modelled_text(const NotModelled& lines);

/// The same as JSON: {"changes_motion": [...], "other": [...]}; as text again.
nlohmann::json json_of(const NotModelled& lines);
std::string not_modelled_text(const nlohmann::json& lines);

}  // namespace borelli
