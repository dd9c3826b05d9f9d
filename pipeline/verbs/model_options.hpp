// What verbs that read a scene of any kind share: the options of reading, and what the file held beside the
// scene.
#pragma once

#include <CLI/CLI.hpp>

#include "dynamics/formats/model_file.hpp"

namespace borelli {

/// Adds --floating, --lock and --minimum-mass.
void add_model_options(CLI::App& verb, ModelOptions& options);

}  // namespace borelli
