// borelli modes SCENE: eigenmodes of small deviations from a steady state.
#include <fmt/core.h>

#include "dynamics/constraints/equilibrium.hpp"
#include "dynamics/constraints/linearize.hpp"
#include "error/json_text.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/state_file.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

struct ModesOptions : StateOptions {
  bool equilibrium = false;
};

json json_of(const Mode& mode, const FileOrder& order) {
  json shape = json::array();
  for (const Eigen::Index i : order.v) shape.push_back({mode.shape[i].real(), mode.shape[i].imag()});
  return {{"eigenvalue", {mode.eigenvalue.real(), mode.eigenvalue.imag()}},
          {"frequency", mode.frequency},
          {"damping_ratio", mode.damping_ratio},
          {"shape", shape}};
}

Result<json> work(const ModesOptions& o, const Command& command) {
  auto given = read_scene_at_state(o, command);
  if (!given) return tl::unexpected(given.error());
  if (o.equilibrium) {
    const auto found = find_equilibrium(given->system, given->state);
    if (!found) return in_file(o.scene, found.error());
    given->state = found->state;
  }
  const auto linear = linearize(given->system, given->state);
  if (!linear) return in_file(o.scene, linear.error());
  json names = json::array(), modes = json::array(), matrix = json::array();
  for (const Eigen::Index i : given->order.v) names.push_back(given->system.velocity_name(int(i)));
  for (const Mode& mode : linear->modes) modes.push_back(json_of(mode, given->order));
  for (Eigen::Index r = 0; r < linear->state_matrix.rows(); ++r)
    matrix.push_back(
        std::vector<double>(linear->state_matrix.row(r).begin(), linear->state_matrix.row(r).end()));
  json answer{{"coordinates", names},
              {"state", json_of(given->state, given->order)},
              {"stability", word_for(linear->stability)},
              {"modes", modes},
              {"basis", rows_in_file_order(linear->basis.transpose(), given->order)},
              {"state_matrix", matrix}};
  if (!command.json) fmt::print("{}\n", json_text(command.complete(answer), 2));
  return answer;
}

}  // namespace

void add_modes(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("modes",
                                      "Print stability, frequencies, damping and mode shapes of small "
                                      "deviations from a steady state as JSON");
  auto o = std::make_shared<ModesOptions>();
  add_state_options(*verb, *o);
  verb->add_flag("--equilibrium", o->equilibrium, "First find an equilibrium near the given state");
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
