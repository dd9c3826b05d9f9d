#include "pipeline/verbs/model_options.hpp"

#include "pipeline/verbs/number_check.hpp"

namespace borelli {

void add_model_options(CLI::App& verb, ModelOptions& options) {
  verb.add_flag("--floating", options.floating, "URDF: the root link moves freely instead of being fixed");
  verb.add_option("--lock", options.locked,
                  "Keep a free coordinate or joint where it starts; may be repeated")
      ->allow_extra_args(false);
  verb.add_option("--minimum-mass", options.minimum_mass,
                  "URDF and OpenSim: replace moving bodies lighter than this by balls of water of this mass, kg")
      ->check(number_not_negative());
}

}  // namespace borelli
