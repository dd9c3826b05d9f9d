// What verbs that read a scene of any kind share: the options of reading, and what the file held beside the
// scene.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "dynamics/model_file.hpp"

namespace borelli {

/// Adds --floating.
void add_model_options(CLI::App& verb, ModelOptions& options);

/// ModelFile::not_modelled for people: a line each.
std::string not_modelled_text(const std::vector<std::string>& lines);

}  // namespace borelli
