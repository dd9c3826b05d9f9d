// borelli evaluate SCENE --state S.json: the equations of motion at one state, as JSON.
#include "dynamics/evaluate.hpp"

#include <fmt/core.h>

#include <optional>

#include "dynamics/derivatives.hpp"
#include "dynamics/model_file.hpp"
#include "pipeline/file_order.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/verb.hpp"
#include "pipeline/whole_file.hpp"

namespace borelli {
namespace {

using nlohmann::json;

// A list of numbers under `key`, in the file's order; missing: `standard`.
Result<Eigen::VectorXd> list_of(const json& state, const std::string& file, const char* key,
                                const std::vector<Eigen::Index>& order, const Eigen::VectorXd& standard) {
  if (!state.contains(key)) return standard;
  const json& list = state.at(key);
  if (!list.is_array() || list.size() != order.size())
    return bad_use(file,
                   fmt::format("{} is {}, expected a list of {} numbers", key,
                               list.is_array() ? fmt::format("a list of {}", list.size()) : list.type_name(),
                               order.size()));
  Eigen::VectorXd out(static_cast<Eigen::Index>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (!list[i].is_number()) return bad_use(file, fmt::format("{}[{}] is not a number", key, i));
    out[order[i]] = list[i].get<double>();
  }
  return out;
}

struct Given {
  State state;
  Eigen::VectorXd efforts;
};

Result<Given> read_state(const std::string& file, const System& system, const FileOrder& order) {
  Given given{system.initial, Eigen::VectorXd::Zero(system.nv)};
  if (file.empty()) return given;
  const auto bytes = read_whole(file);
  if (!bytes) return tl::unexpected(bytes.error());
  const json state = json::parse(*bytes, nullptr, false);
  if (!state.is_object())
    return bad_use(file,
                   R"(is not a JSON object, expected {"t": 0, "q": [...], "v": [...], "efforts": [...]})");
  for (const auto& [key, value] : state.items())
    if (key != "t" && key != "q" && key != "v" && key != "efforts")
      return bad_use(file, fmt::format("unknown key '{}'; known: t, q, v, efforts", key));
  if (state.contains("t") && !state.at("t").is_number()) return bad_use(file, "t is not a number");
  if (!state.contains("q") && system.nq > 0)
    return bad_use(file, fmt::format("q is missing, expected a list of {} numbers", system.nq));

  given.state.t = state.value("t", 0.0);
  auto q = list_of(state, file, "q", order.q, given.state.q);
  auto v = list_of(state, file, "v", order.v, Eigen::VectorXd::Zero(system.nv));
  auto efforts = list_of(state, file, "efforts", order.v, given.efforts);
  for (const auto* list : {&q, &v, &efforts})
    if (!*list) return tl::unexpected(list->error());
  given.state.q = *q, given.state.v = *v, given.efforts = *efforts;
  return given;
}

json answer_of(const Evaluation& e, const System& system, const FileOrder& order) {
  json names = json::array(), mass_matrix = json::array(), jacobian = json::array();
  for (const Eigen::Index i : order.v) {
    names.push_back(e.coordinates[static_cast<std::size_t>(i)]);
    mass_matrix.push_back(in_file_order(e.mass_matrix.row(i).transpose(), order.v));
  }
  json answer{{"coordinates", names},
              {"acceleration", in_file_order(e.acceleration, order.v)},
              {"mass_matrix", mass_matrix},
              {"bias", in_file_order(e.bias, order.v)},
              {"generalized_efforts", in_file_order(e.generalized_efforts, order.v)},
              {"kinetic_energy", e.kinetic_energy},
              {"potential_energy", e.potential_energy}};
  if (!system.driven.empty()) {
    json driven = json::array();
    for (const CoordinateInfo& c : system.driven)
      for (int i = 0; i < c.v_size; ++i)
        driven.push_back(c.v_size == 1 ? c.name : fmt::format("{}[{}]", c.name, i));
    answer["driven"] = driven;
    answer["drive_efforts"] = std::vector<double>(e.drive_efforts.begin(), e.drive_efforts.end());
  }
  if (e.rows.empty()) return answer;
  for (Eigen::Index r = 0; r < e.constraint_jacobian.rows(); ++r)
    jacobian.push_back(in_file_order(e.constraint_jacobian.row(r).transpose(), order.v));
  answer["constraint_rows"] = e.rows;
  answer["constraint_jacobian"] = jacobian;
  answer["constraint_bias"] = std::vector<double>(e.constraint_bias.begin(), e.constraint_bias.end());
  answer["multipliers"] = std::vector<double>(e.multipliers.begin(), e.multipliers.end());
  return answer;
}

// Rows and columns over the coordinates, in the file's order.
json square(const Rows& matrix, const FileOrder& order) {
  json out = json::array();
  for (const Eigen::Index i : order.v) out.push_back(in_file_order(matrix.row(i).transpose(), order.v));
  return out;
}

json derivatives_of(const ForwardDerivatives& d, const FileOrder& order) {
  json by_inertia = json::array();
  for (std::size_t b = 0; b < d.inertials.size(); ++b) {
    json one{{"solid", d.inertials[b]}};
    for (int k = 0; k < 10; ++k)
      one[inertial_numbers[k]] =
          in_file_order(d.acceleration_by_inertia.col(10 * Eigen::Index(b) + k), order.v);
    by_inertia.push_back(one);
  }
  json answer{{"acceleration_by_q", square(d.acceleration_by_q, order)},
              {"acceleration_by_v", square(d.acceleration_by_v, order)},
              {"acceleration_by_efforts", square(d.acceleration_by_efforts, order)},
              {"acceleration_by_inertia", by_inertia}};
  if (d.multipliers_by_q.rows() == 0) return answer;
  const auto rows_of = [&](const Rows& matrix) {
    json out = json::array();
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
      out.push_back(in_file_order(matrix.row(r).transpose(), order.v));
    return out;
  };
  answer["multipliers_by_q"] = rows_of(d.multipliers_by_q);
  answer["multipliers_by_v"] = rows_of(d.multipliers_by_v);
  answer["multipliers_by_efforts"] = rows_of(d.multipliers_by_efforts);
  return answer;
}

struct Options {
  std::string scene, state;
  ModelOptions model;
  bool derivatives = false;
  std::optional<std::string> equations;
};

Result<json> work(const Options& o, const Command& command) {
  const std::string &scene_file = o.scene, &state_file = o.state;
  const auto in_scene = [&](Error error) {
    if (!error.where.starts_with(scene_file))  // what compile refuses names the file already, with the line
      error.where = error.where.empty() ? scene_file : scene_file + ", " + error.where;
    return tl::unexpected(std::move(error));
  };
  const auto model = read_model(scene_file, o.model);
  if (!model) return tl::unexpected(model.error());
  auto system = compile(model->scene);
  if (!system) return in_scene(system.error());
  if (o.equations)
    system->settings.equations = *o.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  const FileOrder order = file_order(model->scene, system->coordinates);
  const auto given = read_state(state_file, *system, order);
  if (!given) return tl::unexpected(given.error());
  if (const auto fits = check_state(*system, given->state); !fits)
    return bad_use(state_file.empty() ? scene_file : state_file, fits.error().message());
  const auto evaluation = evaluate(*system, given->state, given->efforts);
  if (!evaluation) return in_scene(evaluation.error());
  json answer = answer_of(*evaluation, *system, order);
  if (!model->not_modelled.empty()) answer["not_modelled"] = model->not_modelled;
  if (o.derivatives) {
    const auto derivatives = forward_derivatives(*system, given->state, given->efforts);
    if (!derivatives) return in_scene(derivatives.error());
    answer["derivatives"] = derivatives_of(*derivatives, order);
  }
  if (!command.json) fmt::print("{}\n", answer.dump(2));
  return answer;
}

}  // namespace

void add_evaluate(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("evaluate", "Accelerations, mass matrix, bias and energies at a state, as JSON");
  auto o = std::make_shared<Options>();
  verb->add_option("scene", o->scene, "The scene: TOML, MJCF or URDF")->required();
  add_model_options(*verb, o->model);
  verb->add_option(
      "--state", o->state,
      "JSON with t (s), q, v, efforts in the order of the scene's file, as `simulate --json` answers its "
      "`end`; "
      "q must be there, a missing t, v or efforts is zero; without a state file, the scene's initial state");
  verb->add_option("--equations", o->equations, "Equations of motion: along the tree, or the paper's scan")
      ->check(CLI::IsMember({"recursive", "lagrange"}));
  verb->add_flag(
      "--derivatives", o->derivatives,
      "Also how accelerations and multipliers change with q (a ball's by small turns in its own axes), v, "
      "efforts and inertias");
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
