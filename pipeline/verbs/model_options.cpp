#include "pipeline/verbs/model_options.hpp"

#include <fmt/core.h>

#include "pipeline/verbs/number_check.hpp"

namespace borelli {

void add_model_options(CLI::App& verb, ModelOptions& options) {
  verb.add_flag("--floating", options.floating, "URDF: the root link moves freely instead of being fixed");
  verb.add_option("--lock", options.locked,
                  "A free coordinate, or joint, that stays where it starts; may be given several times")
      ->allow_extra_args(false);
  verb.add_option("--minimum-mass", options.minimum_mass,
                  "URDF: a body that moves and weighs less (kg) is taken as a ball of water of that mass")
      ->check(number_not_negative());
}

std::string not_modelled_text(const NotModelled& lines) {
  std::string out;
  for (const std::string& line : lines.other) out += fmt::format("  not modelled: {}\n", line);
  return out;
}

nlohmann::json json_of(const NotModelled& lines) {
  return {{"changes_motion", lines.motion}, {"other", lines.other}};
}

std::string not_modelled_text(const nlohmann::json& lines) {
  return not_modelled_text(NotModelled{lines["changes_motion"].get<std::vector<std::string>>(),
                                       lines["other"].get<std::vector<std::string>>()});
}

}  // namespace borelli
