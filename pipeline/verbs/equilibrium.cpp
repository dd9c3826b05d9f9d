// borelli equilibrium SCENE: finds a state of rest.
#include "dynamics/constraints/equilibrium.hpp"

#include <fmt/core.h>

#include "dynamics/equations/evaluate.hpp"
#include "error/file_ending.hpp"
#include "error/json_text.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/state_file.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

struct EquilibriumOptions : StateOptions {
  std::string output;
};

Result<json> work(const EquilibriumOptions& o, const Command& command) {
  if (!o.output.empty()) {
    if (ending_of(o.output) != ".json")
      return bad_use(o.output, "is not a .json file; end the name in .json");
    if (auto fine = check_writable(o.output); !fine) return tl::unexpected(fine.error());
  }
  const auto given = read_scene_at_state(o, command);
  if (!given) return tl::unexpected(given.error());
  const auto found = find_equilibrium(given->system, given->state);
  if (!found) return in_file(o.scene, found.error());
  if (!found->holds_at.empty())
    command.warn(fmt::format("the balance is that of t = {:.6g} s: {}", found->state.t, found->holds_at));
  const auto there = evaluate(given->system, found->state);
  if (!there) return in_file(o.scene, there.error());
  const json state = json_of(found->state, given->order);
  json names = json::array();
  for (const Eigen::Index i : given->order.v) names.push_back(there->coordinates[std::size_t(i)]);
  json answer{{"coordinates", names},
              {"state", state},
              {"iterations", found->iterations},
              {"imbalance", found->imbalance},
              {"potential_energy", there->potential_energy}};
  if (!there->rows.empty()) {
    answer["constraint_rows"] = there->rows;
    answer["multipliers"] = std::vector<double>(found->multipliers.begin(), found->multipliers.end());
  }
  auto fine = of_numbers(o, std::move(answer));
  if (!fine) return fine;
  if (!o.output.empty())
    if (auto done = write_whole(o.output, json_text(state, 2) + "\n"); !done)
      return tl::unexpected(done.error());
  if (!command.json) fmt::print("{}\n", json_text(command.complete(*fine), 2));
  return fine;
}

}  // namespace

void add_equilibrium(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("equilibrium",
                                      "Find a state of rest near a given state and print it as JSON "
                                      "(`borelli modes` tells whether it is stable)");
  auto o = std::make_shared<EquilibriumOptions>();
  add_state_options(*verb, *o);
  add_output(*verb, o->output, "FILE", "File for the state (.json); --state of other verbs reads it");
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
