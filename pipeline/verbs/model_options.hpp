// Options for verbs that read a scene or model of any format.
#pragma once

#include <CLI/CLI.hpp>

#include "dynamics/formats/model_file.hpp"

namespace borelli {

/// Adds --floating, --lock and --minimum-mass.
void add_model_options(CLI::App& verb, ModelOptions& options);

}  // namespace borelli
