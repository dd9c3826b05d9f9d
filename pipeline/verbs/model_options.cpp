#include "pipeline/verbs/model_options.hpp"

#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {

void add_model_options(CLI::App& verb, ModelOptions& options) {
  verb.add_flag("--floating", options.floating,
                "URDF: let the root link move freely (default: fixed to the world)");
  verb.add_option("--lock", options.locked,
                  "Keep a free coordinate or joint at its initial value, by name; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  verb.add_option(
          "--minimum-mass", options.minimum_mass,
          "URDF and OpenSim: replace moving bodies lighter than this mass by balls of water of this mass, kg")
      ->check(number_not_negative());
  group_options(verb, "How the model is read", {"--floating", "--lock", "--minimum-mass"});
}

}  // namespace borelli
