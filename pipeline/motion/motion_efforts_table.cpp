#include "pipeline/motion/motion_efforts_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "dynamics/equations/evaluate.hpp"
#include "error/printable.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// The coordinate that a column names: the name itself, or the last part but one of a path of OpenSim's
/// states.
std::string coordinate_of(const std::string& column) {
  if (!column.ends_with("/value")) return column;
  const std::string path = column.substr(0, column.size() - 6);
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

/// A load's solids, found once.
struct ActingLoad {
  const ExternalLoad* load = nullptr;
  int solid = -1, axes = -1,
      place = -1;  ///< it acts on; whose axes the force has; whose frame the point is in
};

Result<int> solid_named(const System& system, const std::string& name, const std::string& load) {
  if (name.empty() || name == "ground" || name == world_name) return -1;
  const int solid = solid_index(system, name);
  if (solid < 0)
    return bad_use(fmt::format("external load '{}'", printable(load)),
                   fmt::format("the model has no body named '{}'", printable(name)));
  return solid;
}

Result<std::vector<ActingLoad>> acting_loads(const System& system, const std::vector<ExternalLoad>& loads) {
  std::vector<ActingLoad> out;
  for (const ExternalLoad& load : loads) {
    const auto on = solid_named(system, load.body, load.measured.name);
    const auto axes = solid_named(system, load.force_body, load.measured.name);
    const auto place = solid_named(system, load.point_body, load.measured.name);
    for (const auto* found : {&on, &axes, &place})
      if (!*found) return tl::unexpected(found->error());
    if (*on >= 0) out.push_back({&load, *on, *axes, *place});  // what acts on the ground moves nothing
  }
  return out;
}

/// Linear between samples; null outside of them.
std::optional<SolidWrench> sample(const MeasuredForce& measured, double t) {
  const std::vector<double>& times = measured.times;
  if (times.empty() || t < times.front() - 1e-6 || t > times.back() + 1e-6) return std::nullopt;
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  const auto high = Eigen::Index(std::min<std::size_t>(std::size_t(after - times.begin()), times.size() - 1));
  const Eigen::Index low = std::max<Eigen::Index>(high - 1, 0);
  const double span = times[std::size_t(high)] - times[std::size_t(low)];
  const double share = span > 0 ? std::clamp((t - times[std::size_t(low)]) / span, 0.0, 1.0) : 0;
  const auto between = [&](const Matrix3Xd& values) -> Vector3d {
    return (1 - share) * values.col(low) + share * values.col(high);
  };
  SolidWrench wrench{.solid = 0,
                     .force = between(measured.force),
                     .point = between(measured.point),
                     .moment = between(measured.moment)};
  // at the edge of a stance only one sample has a centre of pressure
  for (Eigen::Index k : {low, high})
    if (!wrench.point.allFinite()) wrench.point = measured.point.col(k);
  if (!wrench.force.allFinite() || !wrench.moment.allFinite() || !wrench.point.allFinite())
    return std::nullopt;
  return wrench;
}

/// Free coordinates of floating bases. A body on the world floats if it has two or three translations. A body
/// without mass may be one of several that make up a floating base, so it counts too.
std::vector<RootResidual> residuals_of(const System& system, const Rows& efforts) {
  std::vector<RootResidual> out;
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    if (body.parent != 0) continue;
    int translations = 0;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s)
      if (const SwitchStep& step = system.steps[std::size_t(s)]; !step.rotates) translations += step.nv;
    if (body.massive && translations < 2) continue;
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const SwitchStep& step = system.steps[std::size_t(s)];
      if (step.drive >= 0) continue;
      for (int u = step.u; u < step.u + step.nv; ++u)
        out.push_back({system.velocity_name(u), step.rotates,
                       std::sqrt(efforts.col(u).squaredNorm() / double(efforts.rows())),
                       efforts.col(u).cwiseAbs().maxCoeff()});
    }
  }
  return out;
}

/// Height of the gravity centre above the scene's origin at the first frame, m; 0 without gravity.
double height_of_centre(const System& system, const RecordedEfforts& efforts) {
  const State first{efforts.times.front(), efforts.q.row(0), efforts.v.row(0)};
  const auto then = evaluate(system, first);
  const Vector3d g = system.parameters.gravity;
  return then && g.norm() > 0 ? -g.normalized().dot(then->momenta.centre) : 0;
}

/// Warns of residuals beyond the advice of Hicks and others: 5 % of the measured force, and 1 % of its moment
/// at the gravity centre's height.
void judge_residuals(const System& system, RecordedEfforts& efforts) {
  if (efforts.peak_force == 0 || efforts.times.empty()) return;
  const auto judge = [&](bool angle, const char* what, const char* unit, double reference, double most,
                         const char* of) {
    double worst = 0;
    for (const RootResidual& r : efforts.residuals)
      if (r.angle == angle) worst = std::max(worst, r.peak);
    const double share = worst / reference;
    if (reference > 0 && share > most)
      efforts.warnings.push_back(
          fmt::format("the largest residual {} at the root, {:.0f} {}, is {:.0f} % of {}; up to {:.0f} % is "
                      "advised (Hicks and others, Journal of Biomechanical Engineering 137, 2015)",
                      what, worst, unit, 100 * share, of, 100 * most));
  };
  judge(false, "force", "N", efforts.peak_force, 0.05, "the largest measured force");
  judge(true, "moment", "N m", efforts.peak_force * height_of_centre(system, efforts), 0.01,
        "that of the largest measured force at the gravity centre's height");
}

/// Warns of efforts that no body exerts: beyond a hundred times the weight, or for moments ten times the
/// weight times the length of the scene.
void judge_sizes(const System& system, RecordedEfforts& efforts) {
  double mass = 0;
  for (const Inertial& inertial : system.parameters.inertials) mass += inertial.mass;
  const double weight = mass * system.parameters.gravity.norm();
  if (!(weight > 0)) return;
  for (const CoordinateInfo& c : system.coordinates) {
    const double peak = efforts.efforts.middleCols(c.v_index, c.v_size).cwiseAbs().maxCoeff();
    const double most = c.angle ? 10 * weight * system.length : 100 * weight;
    if (!(peak > most)) continue;
    efforts.warnings.push_back(fmt::format(
        "the {} of '{}' reaches {:.3g} {}, {:.0f} times the weight{}: the unit of the angles (inDegrees), of "
        "times, or of the forces and their points may be wrong",
        c.angle ? "moment" : "force", c.name, peak, c.angle ? "N m" : "N",
        peak / (c.angle ? weight * system.length : weight), c.angle ? " times the model's size" : ""));
    return;  // (others follow from it)
  }
}

/// Warns of rows that are missing in a recording: their motion is a guess.
void warn_of_gaps(const std::vector<double>& times, std::vector<std::string>& warnings) {
  if (times.size() < 3) return;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  std::vector<double> sorted = steps;
  std::ranges::nth_element(sorted, sorted.begin() + std::ptrdiff_t(sorted.size() / 2));
  const double usual = sorted[sorted.size() / 2];
  const auto largest = std::ranges::max_element(steps);
  if (!(*largest > 3 * usual)) return;
  const auto at = std::size_t(largest - steps.begin());
  warnings.push_back(
      fmt::format("rows are missing between t = {:.6g} s and {:.6g} s, {:.3g} of the usual steps; a "
                  "spline bridges them, so efforts in and beside the gap are a guess",
                  times[at], times[at + 1], *largest / usual));
}

/// Computes absent coordinates that are coupled to others, and removes them from `absent`.
void follow_couplings(const System& system, const std::map<std::string, const CoordinateInfo*>& known,
                      std::set<std::string>& absent, Rows& q) {
  for (bool changed = true; changed;) {  // a chain of couplings takes several rounds
    changed = false;
    for (const Constraint& constraint : system.parameters.constraints) {
      const auto* coupling = std::get_if<CoordinateFunction>(&constraint.kind);
      if (!coupling || !absent.contains(coupling->on.coordinate) ||
          !known.contains(coupling->of.coordinate) || absent.contains(coupling->of.coordinate))
        continue;
      const auto of = q.col(known.at(coupling->of.coordinate)->q_index);
      auto on = q.col(known.at(coupling->on.coordinate)->q_index);
      for (Eigen::Index i = 0; i < q.rows(); ++i) on[i] = at(coupling->function, of[i]).value;
      absent.erase(coupling->on.coordinate);
      changed = true;
    }
  }
}

MotionTable table_by_coordinate(const System& system, const RecordedEfforts& efforts, const Rows& values,
                                const std::string& title, bool powers) {
  MotionTable table{title, {}, efforts.times, values, false};
  for (const CoordinateInfo& c : system.coordinates)
    for (int i = 0; i < c.v_size; ++i)
      table.columns.push_back(system.velocity_name(c.v_index + i) + (powers    ? "_power"
                                                                     : c.angle ? "_moment"
                                                                               : "_force"));
  return table;
}

}  // namespace

Eigen::Index coordinate_column(const MotionTable& table, const std::string& name) {
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (coordinate_of(table.columns[i]) == name) return Eigen::Index(i);
  return -1;
}

Result<TablePositions> positions_in(const System& system, const MotionTable& table) {
  TablePositions out;
  out.positions.times = table.times;
  out.positions.q.resize(table.values.rows(), system.nq);
  std::map<std::string, const CoordinateInfo*> known;
  std::set<std::string> absent;
  std::vector<char> used(table.columns.size(), false);
  for (const CoordinateInfo& c : system.coordinates) {
    static constexpr const char* parts[] = {".w", ".x", ".y", ".z"};
    bool found = false;
    for (int i = 0; i < c.q_size; ++i) {
      const Eigen::Index column = coordinate_column(table, c.q_size == 1 ? c.name : c.name + parts[i]);
      found = column >= 0;
      if (!found) break;
      used[std::size_t(column)] = true;
      const bool degrees = table.in_degrees && c.angle && c.q_size == 1;
      out.positions.q.col(c.q_index + i) = table.values.col(column) * (degrees ? std::numbers::pi / 180 : 1);
    }
    known[c.name] = &c;
    if (found) continue;
    absent.insert(c.name);
    for (int i = 0; i < c.q_size; ++i)
      out.positions.q.col(c.q_index + i).setConstant(system.initial.q[c.q_index + i]);
  }
  const bool has_some = absent.size() < system.coordinates.size();
  if (has_some) follow_couplings(system, known, absent, out.positions.q);
  std::vector<std::string> missing;
  for (const CoordinateInfo& c : system.coordinates)
    if (absent.contains(c.name)) missing.push_back(printable(c.name));
  if (!has_some)
    return bad_use("motion", fmt::format("has no column for any coordinate of the model; expected {}",
                                         name_list(missing)));
  for (Eigen::Index i = 0; i < out.positions.q.rows(); ++i)
    if (!out.positions.q.row(i).allFinite())
      return bad_use("motion", fmt::format("row {} (t = {} s) has a value that is not a number", i + 1,
                                           table.times[std::size_t(i)]));
  if (!missing.empty())
    out.warnings.push_back(fmt::format(
        "kept at their initial values, because the motion has no columns for them: {}", name_list(missing)));
  std::vector<std::string> unused;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!used[i] && !table.columns[i].ends_with("/speed")) unused.push_back(printable(table.columns[i]));
  if (!unused.empty())
    out.warnings.push_back(
        fmt::format("ignored columns, which are not free coordinates of the model: {}", name_list(unused)));
  return out;
}

Result<RecordedEfforts> efforts_of(const System& system, const RecordedPositions& positions,
                                   const std::vector<ExternalLoad>& loads,
                                   const MotionEffortsRequest& request) {
  const auto motion = RecordedMotion::of(system, positions, request.cutoff);
  if (!motion) return tl::unexpected(motion.error());
  const auto acting = acting_loads(system, loads);
  if (!acting) return tl::unexpected(acting.error());
  RecordedEfforts out;
  for (double t : positions.times)
    if (t >= request.time_range.first - 1e-6 && t <= request.time_range.second + 1e-6) out.times.push_back(t);
  if (out.times.empty()) return bad_use("motion", "has no row within the time range");
  const auto count = Eigen::Index(out.times.size());
  out.q.resize(count, system.nq);
  for (Rows* rows : {&out.v, &out.a, &out.efforts}) rows->resize(count, system.nv);
  MotionEfforts needed(system);
  SolidPoses poses(system);
  State state;
  VectorXd a;
  std::vector<SolidWrench> wrenches;
  std::size_t outside = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = out.times[std::size_t(i)];
    motion->at(t, state, a);
    poses.update(t, state.q);
    wrenches.clear();
    for (const ActingLoad& load : *acting) {
      auto wrench = sample(load.load->measured, t);
      outside += !load.load->measured.times.empty() && (t < load.load->measured.times.front() - 1e-6 ||
                                                        t > load.load->measured.times.back() + 1e-6);
      if (!wrench) continue;
      const Matrix3d R = poses.of(load.axes).R;
      wrench->solid = load.solid;
      wrench->force = R * wrench->force;
      wrench->moment = R * wrench->moment;
      wrench->point = poses.of(load.place) * wrench->point;
      out.peak_force = std::max(out.peak_force, wrench->force.norm());
      wrenches.push_back(*wrench);
    }
    out.q.row(i) = state.q.transpose();
    out.v.row(i) = state.v.transpose();
    out.a.row(i) = a.transpose();
    out.efforts.row(i) = needed.needed(state, a, wrenches).transpose();
    if (request.progress) request.progress(double(i + 1) / double(count));
  }
  out.powers = out.efforts.cwiseProduct(out.v);
  out.residuals = residuals_of(system, out.efforts);
  if (outside > 0)
    out.warnings.push_back(
        "the measured forces do not cover the whole motion; outside their samples they are zero");
  judge_residuals(system, out);
  judge_sizes(system, out);
  warn_of_gaps(positions.times, out.warnings);
  return out;
}

MotionTable effort_table_of(const System& system, const RecordedEfforts& efforts) {
  return table_by_coordinate(system, efforts, efforts.efforts, "Inverse Dynamics Generalized Forces", false);
}

MotionTable power_table_of(const System& system, const RecordedEfforts& efforts) {
  return table_by_coordinate(system, efforts, efforts.powers, "Joint powers", true);
}

}  // namespace borelli
