// borelli evaluate SCENE --state S.json: the equations of motion at one state, as JSON.
#include "dynamics/equations/evaluate.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <sstream>

#include "dynamics/equations/derivatives.hpp"
#include "dynamics/equations/reaction.hpp"
#include "error/json_text.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/state_file.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "process/memory.hpp"

namespace borelli {
namespace {

using nlohmann::json;

std::vector<double> list_of(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

// Rows and columns over the coordinates, in the file's order.
json square(const Rows& matrix, const FileOrder& order) {
  json out = json::array();
  for (const Eigen::Index i : order.v) out.push_back(in_file_order(matrix.row(i).transpose(), order.v));
  return out;
}

json answer_of(const Evaluation& e, const System& system, const FileOrder& order) {
  json names = json::array();
  for (const Eigen::Index i : order.v) names.push_back(e.coordinates[static_cast<std::size_t>(i)]);
  json answer{{"coordinates", names},
              {"acceleration", in_file_order(e.acceleration, order.v)},
              {"mass_matrix", square(e.mass_matrix, order)},
              {"bias", in_file_order(e.bias, order.v)},
              {"generalized_efforts", in_file_order(e.generalized_efforts, order.v)},
              {"kinetic_energy", e.kinetic_energy},
              {"potential_energy", e.potential_energy},
              {"total_energy", e.kinetic_energy + e.potential_energy},
              {"mass", e.momenta.mass},
              {"gravity_centre", list_of(e.momenta.centre)},
              {"gravity_centre_velocity", list_of(e.momenta.velocity)},
              {"linear_momentum", list_of(e.momenta.linear)},
              {"angular_momentum", list_of(e.momenta.angular)}};
  if (!system.driven.empty()) {
    json driven = json::array();
    for (const CoordinateInfo& c : system.driven)
      for (int i = 0; i < c.v_size; ++i)
        driven.push_back(c.v_size == 1 ? c.name : fmt::format("{}[{}]", c.name, i));
    answer["driven"] = driven;
    answer["drive_efforts"] = list_of(e.drive_efforts);
  }
  if (e.rows.empty()) return answer;
  answer["constraint_rows"] = e.rows;
  answer["constraint_jacobian"] = rows_in_file_order(e.constraint_jacobian, order);
  answer["constraint_bias"] = list_of(e.constraint_bias);
  answer["constraint_position"] = list_of(e.constraint_position);
  answer["constraint_rate"] = list_of(e.constraint_rate);
  answer["multipliers"] = list_of(e.multipliers);
  return answer;
}

// Jacobians of the gravity centre and the momentum.
void add_jacobians(const Evaluation& e, const FileOrder& order, json& answer) {
  const double mass = e.momenta.mass > 0 ? e.momenta.mass : 1;
  answer["gravity_centre_jacobian"] = rows_in_file_order(e.centroidal.matrix.bottomRows<3>() / mass, order);
  answer["gravity_centre_bias"] = list_of(e.centroidal.bias.tail<3>() / mass);
  answer["centroidal_momentum_matrix"] = rows_in_file_order(e.centroidal.matrix, order);
  answer["centroidal_momentum_bias"] = list_of(e.centroidal.bias);
}

// SOLID:X,Y,Z, or SOLID alone for its origin.
Result<SolidPoint> point_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  SolidPoint out{text.substr(0, colon), Eigen::Vector3d::Zero()};
  if (colon == std::string::npos) return out;
  std::istringstream numbers(text.substr(colon + 1));
  char comma[2] = {',', ','};
  numbers >> out.point[0] >> comma[0] >> out.point[1] >> comma[1] >> out.point[2];
  if (!numbers || numbers.peek() != EOF || comma[0] != ',' || comma[1] != ',')
    return bad_use(
        "--point " + text,
        "is not a point; expected SOLID:X,Y,Z in the solid's axes, in metres, or SOLID for its origin");
  return out;
}

Result<json> points_of(const std::vector<std::string>& texts, const SceneAtState& given) {
  json out = json::array();
  for (const std::string& text : texts) {
    const auto at = point_of(text);
    if (!at) return tl::unexpected(at.error());
    const auto motion = point_motion(given.system, given.state, *at);
    if (!motion) return bad_use("--point " + text, motion.error().what);
    out.push_back({{"solid", at->solid},
                   {"point", list_of(at->point)},
                   {"position", list_of(motion->position)},
                   {"velocity", list_of(motion->velocity)},
                   {"angular_velocity", list_of(motion->angular_velocity)},
                   {"jacobian", rows_in_file_order(motion->jacobian, given.order)},
                   {"angular_jacobian", rows_in_file_order(motion->angular_jacobian, given.order)},
                   {"bias", list_of(motion->bias)},
                   {"angular_bias", list_of(motion->angular_bias)}});
  }
  return out;
}

Result<json> reactions_of(const SceneAtState& given, const Evaluation& e, bool parents_axes) {
  auto reactions = Reactions::of(given.model.scene);
  if (!reactions) return tl::unexpected(reactions.error());
  json out = json::array();
  const auto found = reactions->at(given.state, e.acceleration, e.multipliers);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const JointReaction& r = found[i];
    const Eigen::Matrix3d R =
        parents_axes ? Eigen::Matrix3d(r.R_WP.transpose()) : Eigen::Matrix3d::Identity();
    out.push_back({{"solid", reactions->solids()[i]},
                   {"parent", reactions->parents()[i]},
                   {"point", list_of(r.point)},
                   {"force", list_of(R * r.force)},
                   {"moment", list_of(R * r.moment)},
                   {"unique", r.unique}});
  }
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
  answer["multipliers_by_q"] = rows_in_file_order(d.multipliers_by_q, order);
  answer["multipliers_by_v"] = rows_in_file_order(d.multipliers_by_v, order);
  answer["multipliers_by_efforts"] = rows_in_file_order(d.multipliers_by_efforts, order);
  return answer;
}

struct EvaluateOptions : StateOptions {
  bool derivatives = false, jacobians = false;
  std::string reactions;
  std::vector<std::string> points;
};

Result<json> work(const EvaluateOptions& o, const Command& command) {
  const auto given = read_scene_at_state(o, command);
  if (!given) return tl::unexpected(given.error());
  // Two copies of the matrix as numbers, two as JSON, and its text of 26 bytes a number. A text that grows
  // may take three times its size.
  const double size = given->system.nv;
  const double bytes = size * size * (2 * sizeof(double) + 2 * sizeof(json) + 3 * 26);
  if (auto fits =
          admit_memory(o.scene, fmt::format("the mass matrix of {} coordinates as text", size), bytes);
      !fits)
    return tl::unexpected(fits.error());
  const auto evaluation = evaluate(given->system, given->state, given->efforts);
  if (!evaluation) return in_file(o.scene, evaluation.error());
  if (const std::string violated = violation(given->system, *evaluation); !violated.empty())
    command.warn(violated + " at this state; the accelerations keep its rate, not its position");
  json answer = answer_of(*evaluation, given->system, given->order);
  if (o.derivatives) {
    const auto derivatives = forward_derivatives(given->system, given->state, given->efforts);
    if (!derivatives) return in_file(o.scene, derivatives.error());
    answer["derivatives"] = derivatives_of(*derivatives, given->order);
  }
  if (o.jacobians) add_jacobians(*evaluation, given->order, answer);
  if (!o.points.empty()) {
    const auto points = points_of(o.points, *given);
    if (!points) return tl::unexpected(points.error());
    answer["points"] = *points;
  }
  if (!o.reactions.empty()) {
    const auto reactions = reactions_of(*given, *evaluation, o.reactions == "parent");
    if (!reactions) return in_file(o.scene, reactions.error());
    answer["reactions"] = *reactions;
  }
  auto fine = of_numbers(o, std::move(answer));
  if (fine && !command.json) fmt::print("{}\n", json_text(command.complete(*fine), 2));
  return fine;
}

}  // namespace

void add_evaluate(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand(
      "evaluate",
      "Print accelerations, mass matrix, bias, energies, momenta and joint reactions at one state as JSON");
  auto o = std::make_shared<EvaluateOptions>();
  add_state_options(*verb, *o);
  verb->add_flag("--derivatives", o->derivatives,
                 "Add the derivatives of accelerations and multipliers by q (for a ball: by small rotations "
                 "about its own axes), v, efforts and inertias");
  verb->add_flag("--jacobians", o->jacobians,
                 "Add the gravity centre's Jacobian and the centroidal momentum matrix (angular rows first, "
                 "then linear)");
  verb->add_option("--point", o->points,
                   "Add position, velocity, Jacobian and bias of a point of a solid, SOLID:X,Y,Z in metres; "
                   "may be repeated")
      ->type_name("POINT")
      ->allow_extra_args(false);
  verb->add_option("--reactions-in", o->reactions,
                   "Add the reaction on each solid from its parent through the joint: force, and moment "
                   "about the joint's point, in the axes of the world or of the parent")
      ->check(one_of({"world", "parent"}));
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
