#include "pipeline/verbs/model_options.hpp"

#include <fmt/core.h>

namespace borelli {

void add_model_options(CLI::App& verb, ModelOptions& options) {
  verb.add_flag("--floating", options.floating, "URDF: the root link moves freely instead of being fixed");
}

std::string not_modelled_text(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += fmt::format("  not modelled: {}\n", line);
  return out;
}

}  // namespace borelli
