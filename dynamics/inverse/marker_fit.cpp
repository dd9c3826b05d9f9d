#include "dynamics/inverse/marker_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "dynamics/constraints/local_coordinates.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/numbers/rotation_vector.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Sums over weighted points x with residuals r = x - y, about the world's origin. A body's own sums, then
/// those of all that it carries.
struct PointSums {
  double weight = 0;
  Vector3d first = Vector3d::Zero();     ///< sum w x
  Matrix3d second = Matrix3d::Zero();    ///< sum w (|x|^2 1 - x x^T)
  Vector3d force = Vector3d::Zero();     ///< sum w r
  Matrix3d residual = Matrix3d::Zero();  ///< sum w x r^T

  void add(double w, const Vector3d& x, const Vector3d& r) {
    weight += w;
    first += w * x;
    second += w * (x.squaredNorm() * Matrix3d::Identity() - x * x.transpose());
    force += w * r;
    residual += w * x * r.transpose();
  }
  void add(const PointSums& other) {
    weight += other.weight;
    first += other.first;
    second += other.second;
    force += other.force;
    residual += other.residual;
  }
  /// sum w x cross r
  Vector3d moment() const {
    return {residual(1, 2) - residual(2, 1), residual(2, 0) - residual(0, 2),
            residual(0, 1) - residual(1, 0)};
  }
};

/// A unit velocity as the motion of the point of its solid that is at the world's origin.
struct Twist {
  Vector3d angular, linear;
};

struct PlacedMarker {
  int body = 0;
  Vector3d place;  ///< in the body's frame, m
  double weight = 0;
};

struct DrawnCoordinate {
  int q = 0, u = 0;
  double weight = 0;
};

/// A joint's rotation that is drawn towards where the scene starts.
struct RestingRotation {
  int q = 0, u = 0, nq = 1;
};

struct Bounds {
  int q = 0, u = 0;
  double lower = 0, upper = 0;
};

/// The goal and its derivatives at one pose.
struct GoalTerms {
  double value = 0;
  VectorXd gradient;  ///< nv
  MatrixXd hessian;   ///< nv x nv
};

}  // namespace

struct MarkerFit::Work {
  Work(const System& of, std::vector<FollowedMarker> marker_tasks,
       std::vector<FollowedCoordinate> coordinate_tasks, const MarkerFitSettings& how)
      : system(of),
        settings(how),
        tasks(std::move(marker_tasks)),
        coordinate_names(std::move(coordinate_tasks)),
        kinematics(of, Equations::recursive),
        sums(of.bodies.size()),
        twists(std::size_t(of.nv)) {}

  const System& system;
  MarkerFitSettings settings;
  std::vector<FollowedMarker> tasks;
  std::vector<FollowedCoordinate> coordinate_names;
  std::vector<PlacedMarker> markers;
  std::vector<DrawnCoordinate> drawn;
  std::vector<RestingRotation> resting;
  std::vector<Bounds> bounds;
  std::vector<int> rows;               ///< bilateral rows on positions
  std::optional<Workspace> workspace;  ///< only with such rows
  Kinematics kinematics;
  std::vector<PointSums> sums;
  std::vector<Twist> twists;
  GoalTerms goal;
  VectorXd row_values, multipliers;
  MatrixXd row_jacobian;

  /// Runs with derivatives at q; `false` fills the value alone.
  double evaluate(double t, const VectorXd& q, const Eigen::Matrix3Xd& measured, const VectorXd& values,
                  bool derivatives);
  void draw_to_rest(const VectorXd& q, bool derivatives);
  void carry_sums_inwards();
  void fill_hessian();
  void fill_column(const PointSums& carried, std::size_t body, int step, int u);
  Result<void> find_rows(double t, const VectorXd& q);
  VectorXd step(double damping, const std::vector<char>& at_limit);
  double shortening(const VectorXd& x) const;
  std::vector<char> find_at_limit(const VectorXd& q) const;
  VectorXd moved(const VectorXd& q, const VectorXd& x) const;
  double row_error() const;
  double step_size(const VectorXd& before, const VectorXd& after) const;
  MarkerFrame frame(const Eigen::Matrix3Xd& measured) const;
};

double MarkerFit::Work::evaluate(double t, const VectorXd& q, const Eigen::Matrix3Xd& measured,
                                 const VectorXd& values, bool derivatives) {
  update_kinematics(system, system.parameters, t, q.data(), nullptr, kinematics);
  if (derivatives) std::fill(sums.begin(), sums.end(), PointSums{});
  double weights = 0, squares = 0;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const PlacedMarker& marker = markers[m];
    if (marker.weight == 0 || !measured.col(Eigen::Index(m)).allFinite()) continue;
    const Vector3d x = kinematics.bodies[std::size_t(marker.body)].X * marker.place;
    const Vector3d r = x - measured.col(Eigen::Index(m));
    weights += marker.weight;
    squares += marker.weight * r.squaredNorm();
    if (derivatives) sums[std::size_t(marker.body)].add(marker.weight, x, r);
  }
  const double scale = weights > 0 ? 1 / weights : 0;
  goal.value = squares * scale / 2;
  if (derivatives) {
    goal.gradient.setZero(system.nv);
    goal.hessian.setZero(system.nv, system.nv);
    carry_sums_inwards();
    fill_hessian();
    goal.gradient *= scale;
    goal.hessian *= scale;
  }
  for (std::size_t c = 0; c < drawn.size(); ++c) {
    const double away = q[drawn[c].q] - values[Eigen::Index(c)];
    if (!std::isfinite(away)) continue;
    goal.value += drawn[c].weight * away * away / 2;
    if (!derivatives) continue;
    goal.gradient[drawn[c].u] += drawn[c].weight * away;
    goal.hessian(drawn[c].u, drawn[c].u) += drawn[c].weight;
  }
  draw_to_rest(q, derivatives);
  return goal.value;
}

/// Adds sum w_i a_i^2 / 2 for each resting rotation, where a is its angle, or a ball's rotation vector, from
/// the start. Second derivatives of a are left out.
void MarkerFit::Work::draw_to_rest(const VectorXd& q, bool derivatives) {
  for (const RestingRotation& r : resting) {
    const int size = r.nq == 4 ? 3 : 1;
    const VectorXd weights = settings.rest_weights.segment(r.u, size);
    VectorXd away(size);
    MatrixXd slopes = MatrixXd::Identity(size, size);  // of a along the ball's own axes
    if (r.nq == 4) {
      const Vector3d a = logarithm(product(conjugate(system.initial.q.segment<4>(r.q)), q.segment<4>(r.q)));
      for (int i = 0; i < 3; ++i) slopes.col(i) = rotation_vector_rate(a, Vector3d::Unit(i));
      away = a;
    } else {
      away[0] = q[r.q] - system.initial.q[r.q];
    }
    goal.value += weights.dot(away.cwiseAbs2()) / 2;
    if (!derivatives) continue;
    goal.gradient.segment(r.u, size) += slopes.transpose() * weights.cwiseProduct(away);
    goal.hessian.block(r.u, r.u, size, size) += slopes.transpose() * weights.asDiagonal() * slopes;
  }
}

void MarkerFit::Work::carry_sums_inwards() {
  for (std::size_t b = sums.size() - 1; b > 0; --b) sums[std::size_t(system.bodies[b].parent)].add(sums[b]);
}

void MarkerFit::Work::fill_hessian() {
  for (int u = 0; u < system.nv; ++u) {
    const Vector3d angular = kinematics.angular(u);
    twists[std::size_t(u)] = {angular, kinematics.linear(u) - angular.cross(kinematics.origin(u))};
  }
  for (std::size_t b = 1; b < sums.size(); ++b) {
    if (sums[b].weight == 0) continue;
    const Body& body = system.bodies[b];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      if (system.steps[std::size_t(s)].drive >= 0) continue;
      for (int u = system.steps[std::size_t(s)].u;
           u < system.steps[std::size_t(s)].u + system.steps[std::size_t(s)].nv; ++u)
        fill_column(sums[b], b, s, u);
    }
  }
}

/// Fills column u of the Hessian: the rows of its own switch `step` and of all switches before it, and the
/// gradient's entry u. `carried` sums the points that u moves. A point x moves by
/// J_u(x) = linear + angular cross x per unit of u. Every switch i before u rotates it:
/// dJ_u/dq_i = angular_i cross J_u. For two axes i, u of one ball the derivative depends on their order; the
/// mean of both orders is the second derivative by the ball's rotation vector.
void MarkerFit::Work::fill_column(const PointSums& carried, std::size_t body, int step, int u) {
  struct Products {
    Vector3d force, moment, bend;  ///< of sum w J_u, of sum w x cross J_u, of sum w J_u cross r
  };
  const auto products = [&](const Twist& twist) {
    const Vector3d& w = twist.angular;
    return Products{carried.weight * twist.linear + w.cross(carried.first),
                    carried.first.cross(twist.linear) + carried.second * w,
                    twist.linear.cross(carried.force) + carried.residual * w - carried.residual.trace() * w};
  };
  const Twist& twist = twists[std::size_t(u)];
  const Products own = products(twist);
  goal.gradient[u] = twist.linear.dot(carried.force) + twist.angular.dot(carried.moment());
  for (std::size_t at = body; at > 0; at = std::size_t(system.bodies[at].parent)) {
    const Body& before = system.bodies[at];
    const int last = at == body ? step : before.first_step + before.step_count - 1;
    for (int s = last; s >= before.first_step; --s) {
      const SwitchStep& other = system.steps[std::size_t(s)];
      if (other.drive >= 0) continue;
      for (int i = other.u; i < other.u + other.nv; ++i) {
        const Twist& by = twists[std::size_t(i)];
        double bend = by.angular.dot(own.bend);
        if (s == step && i != u) bend = (bend + twist.angular.dot(products(by).bend)) / 2;
        const double entry = by.linear.dot(own.force) + by.angular.dot(own.moment) + bend;
        goal.hessian(i, u) = goal.hessian(u, i) = entry;
      }
    }
  }
}

Result<void> MarkerFit::Work::find_rows(double t, const VectorXd& q) {
  if (rows.empty()) return {};
  const VectorXd still = VectorXd::Zero(system.nv);
  if (const Fault fault = update_terms(system, system.parameters, t, q.data(), still.data(), *workspace))
    return tl::unexpected(describe(system, fault, t));
  const auto count = Eigen::Index(rows.size());
  row_values.resize(count);
  row_jacobian.resize(count, system.nv);
  for (Eigen::Index k = 0; k < count; ++k) {
    const int row = rows[std::size_t(k)];
    const double scale = 1 / system.row_scale[std::size_t(row)];
    row_values[k] = scale * workspace->rows.h[row];
    row_jacobian.row(k) = scale * workspace->rows.L.row(row).head(system.nv);
  }
  return {};
}

double MarkerFit::Work::row_error() const { return rows.empty() ? 0 : row_values.cwiseAbs().sum(); }

/// Which velocity components stay at an end of their range: those that the gradient pushes outwards.
std::vector<char> MarkerFit::Work::find_at_limit(const VectorXd& q) const {
  std::vector<char> at_limit(std::size_t(system.nv), false);
  for (const Bounds& b : bounds)
    at_limit[std::size_t(b.u)] =
        (q[b.q] <= b.lower && goal.gradient[b.u] > 0) || (q[b.q] >= b.upper && goal.gradient[b.u] < 0);
  return at_limit;
}

/// The damped Newton step on the constraints' tangents, zero where `at_limit`. Empty: the damped matrix is not
/// positive definite.
VectorXd MarkerFit::Work::step(double damping, const std::vector<char>& at_limit) {
  MatrixXd H = goal.hessian;
  const double floor = std::max(H.diagonal().cwiseAbs().maxCoeff() * 1e-12, 1e-300);
  for (Eigen::Index i = 0; i < H.rows(); ++i) H(i, i) += damping * std::abs(H(i, i)) + floor;
  VectorXd gradient = goal.gradient;
  MatrixXd L = row_jacobian;
  for (Eigen::Index i = 0; i < H.rows(); ++i) {
    if (!at_limit[std::size_t(i)]) continue;
    H.row(i).setZero();
    H.col(i).setZero();
    H(i, i) = 1;
    gradient[i] = 0;
    if (L.size() > 0) L.col(i).setZero();
  }
  const Eigen::LLT<MatrixXd> factor(H);
  if (factor.info() != Eigen::Success) return {};
  VectorXd x = factor.solve(-gradient);
  if (!rows.empty()) {
    const MatrixXd across = factor.solve(L.transpose());
    multipliers = (L * across).completeOrthogonalDecomposition().solve(-row_values - L * x);
    x += across * multipliers;
  }
  return x.allFinite() ? x : VectorXd();
}

/// The share of a step that turns no coordinate by more than half a radian and moves none by more than half
/// of the scene's length: longer ones would leave the branch that the start is on, such as a knee by a full
/// turn.
double MarkerFit::Work::shortening(const VectorXd& x) const {
  double longest = 0;
  for (const CoordinateInfo& c : system.coordinates)
    for (int i = c.v_index; i < c.v_index + c.v_size; ++i)
      longest = std::max(longest, std::abs(x[i]) / (c.angle ? 1 : system.length));
  return longest > 0.5 ? 0.5 / longest : 1;
}

VectorXd MarkerFit::Work::moved(const VectorXd& q, const VectorXd& x) const {
  VectorXd to = q;
  from_local_coordinates(system, q.data(), x.data(), to.data());
  for (const Bounds& b : bounds) to[b.q] = std::clamp(to[b.q], b.lower, b.upper);
  return to;
}

double MarkerFit::Work::step_size(const VectorXd& before, const VectorXd& after) const {
  double size = 0;
  for (const CoordinateInfo& c : system.coordinates)
    for (int i = c.q_index; i < c.q_index + c.q_size; ++i)
      size = std::max(size, std::abs(after[i] - before[i]) / (c.angle ? 1 : system.length));
  return size;
}

MarkerFrame MarkerFit::Work::frame(const Eigen::Matrix3Xd& measured) const {
  MarkerFrame out;
  const auto count = Eigen::Index(markers.size());
  out.model.resize(3, count);
  out.errors.resize(count);
  double squares = 0;
  for (Eigen::Index m = 0; m < count; ++m) {
    const PlacedMarker& marker = markers[std::size_t(m)];
    out.model.col(m) = kinematics.bodies[std::size_t(marker.body)].X * marker.place;
    out.errors[m] = measured.col(m).allFinite() ? (out.model.col(m) - measured.col(m)).norm() : std::nan("");
    if (marker.weight == 0 || std::isnan(out.errors[m])) continue;
    squares += out.errors[m] * out.errors[m];
    ++out.seen;
    if (out.worst < 0 || out.errors[m] > out.errors[out.worst]) out.worst = int(m);
  }
  if (out.seen > 0) out.rms = std::sqrt(squares / out.seen);
  return out;
}

MarkerFit::MarkerFit(std::unique_ptr<Work> work) : work_(std::move(work)) {}
MarkerFit::MarkerFit(MarkerFit&&) noexcept = default;
MarkerFit& MarkerFit::operator=(MarkerFit&&) noexcept = default;
MarkerFit::~MarkerFit() = default;

const std::vector<FollowedMarker>& MarkerFit::markers() const { return work_->tasks; }
const std::vector<FollowedCoordinate>& MarkerFit::coordinates() const { return work_->coordinate_names; }

Result<MarkerFit> MarkerFit::create(const System& system, std::vector<FollowedMarker> markers,
                                    std::vector<FollowedCoordinate> coordinates,
                                    const MarkerFitSettings& settings) {
  auto work = std::make_unique<Work>(system, std::move(markers), std::move(coordinates), settings);
  double weights = 0;
  for (const FollowedMarker& task : work->tasks) {
    const std::string where = fmt::format("marker '{}'", task.name);
    const auto found = std::find(system.solids.begin(), system.solids.end(), task.at.solid);
    if (found == system.solids.end())
      return bad_use(where, "the model has no solid of the name that it is placed in");
    if (!(task.weight >= 0) || !std::isfinite(task.weight))
      return bad_use(where, "its weight is not a number of at least 0");
    if (!task.at.point.allFinite()) return bad_use(where, "its place in the solid is not a finite number");
    const auto solid = std::size_t(found - system.solids.begin());
    work->markers.push_back(
        {system.solid_bodies[solid], system.parameters.solid_places[solid] * task.at.point, task.weight});
    weights += task.weight;
  }
  for (const FollowedCoordinate& task : work->coordinate_names) {
    const std::string where = fmt::format("coordinate task '{}'", task.coordinate);
    const auto found = std::find_if(system.coordinates.begin(), system.coordinates.end(),
                                    [&](const CoordinateInfo& c) { return c.name == task.coordinate; });
    if (found == system.coordinates.end() || found->q_size != 1)
      return bad_use(where, "the model has no free scalar coordinate of this name");
    if (!(task.weight >= 0) || !std::isfinite(task.weight))
      return bad_use(where, "its weight is not a number of at least 0");
    work->drawn.push_back({found->q_index, found->v_index, task.weight});
    weights += task.weight;
  }
  if (weights == 0) return bad_use("fit to markers", "no marker and no coordinate has a weight");
  if (settings.rest_weights.size() != 0 && settings.rest_weights.size() != system.nv)
    return bad_use("fit to markers", "the rest weights are not one per velocity component");
  if (settings.rest_weights.size() != 0)
    for (const SwitchStep& step : system.steps)
      if (step.drive < 0 && step.rotates && settings.rest_weights.segment(step.u, step.nv).maxCoeff() > 0)
        work->resting.push_back({step.q, step.u, step.nq});
  if (settings.within_ranges)
    for (const System::LimitedCoordinate& limited : system.ranges) {
      const CoordinateInfo& c = system.coordinates[std::size_t(limited.coordinate)];
      if (c.q_size == 1)
        work->bounds.push_back({c.q_index, c.v_index, limited.ranges[0].lower, limited.ranges[0].upper});
    }
  std::vector<char> of_contact(std::size_t(system.rows), false);
  for (const Contact& contact : system.contacts)
    for (int row = contact.row; row < contact.row + (contact.tangents ? 3 : 1); ++row)
      of_contact[std::size_t(row)] = true;
  for (int row = 0; row < system.rows; ++row)
    if (!of_contact[std::size_t(row)] && !system.kinematic_rows[std::size_t(row)]) work->rows.push_back(row);
  if (!work->rows.empty()) work->workspace.emplace(system);
  return MarkerFit(std::move(work));
}

Result<MarkerFrame> MarkerFit::fit(double t, const Eigen::Matrix3Xd& measured, const VectorXd& values,
                                   VectorXd& q) {
  Work& w = *work_;
  if (measured.cols() != Eigen::Index(w.markers.size()) || values.size() != Eigen::Index(w.drawn.size()) ||
      q.size() != w.system.nq)
    return bad_use("fit to markers", "the numbers of markers, values or positions are not those of the fit");
  VectorXd at = w.moved(q, VectorXd::Zero(w.system.nv)), trial;
  double damping = 0, penalty = 0;
  bool converged = false;
  int iteration = 0;
  for (; iteration < w.settings.most_iterations && !converged; ++iteration) {
    w.evaluate(t, at, measured, values, true);
    if (auto found = w.find_rows(t, at); !found) return tl::unexpected(found.error());
    const std::vector<char> at_limit = w.find_at_limit(at);
    const double rows_before = w.row_error(), goal_before = w.goal.value;
    // lower the damping after a step that reduces the goal; raise it until one does
    bool lower = false;
    for (int attempt = 0; attempt < 30 && !lower; ++attempt) {
      VectorXd x = w.step(damping, at_limit);
      if (x.size() > 0) {
        x *= w.shortening(x);
        if (!w.rows.empty()) penalty = std::max(penalty, 2 * w.multipliers.cwiseAbs().maxCoeff());
        trial = w.moved(at, x);
        const double size = w.step_size(at, trial);
        const double value = w.evaluate(t, trial, measured, values, false);
        if (auto found = w.find_rows(t, trial); !found) return tl::unexpected(found.error());
        const double before = goal_before + penalty * rows_before, after = value + penalty * w.row_error();
        converged = size <= w.settings.tolerance && damping <= 1 && w.row_error() < 1e-9;
        lower = after < before || converged || (size <= 1e-3 && after <= before * (1 + 1e-12));
      }
      if (lower)
        damping = damping < 1e-6 ? 0 : damping / 10;
      else
        damping = std::max(10 * damping, 1e-4);
      if (!lower) {  // derivatives again belong to `at`
        w.evaluate(t, at, measured, values, true);
        if (auto found = w.find_rows(t, at); !found) return tl::unexpected(found.error());
      }
    }
    if (!lower) break;
    at = trial;
  }
  w.evaluate(t, at, measured, values, true);
  if (auto found = w.find_rows(t, at); !found) return tl::unexpected(found.error());
  if (w.row_error() > 1e-6)
    return bad_use("fit to markers", "the constraints of the model cannot be satisfied near the markers");
  q = at;
  MarkerFrame out = w.frame(measured);
  out.iterations = iteration;
  out.converged = converged;
  const std::vector<char> at_limit = w.find_at_limit(q);
  for (std::size_t u = 0; u < at_limit.size(); ++u)
    if (at_limit[u]) out.at_range.push_back(int(u));
  return out;
}

std::vector<std::string> MarkerFit::undetermined() const {
  const Work& w = *work_;
  std::vector<std::string> names;
  if (w.goal.hessian.size() == 0) return names;
  // rows tie coordinates, too
  MatrixXd H = w.goal.hessian;
  const double largest = H.diagonal().cwiseAbs().maxCoeff();
  if (!w.rows.empty()) H += largest * w.row_jacobian.transpose() * w.row_jacobian;
  for (Eigen::Index i = 0; i < H.rows(); ++i) {  // in units that each coordinate moves its own points by
    const double scale = H(i, i) > 1e-12 * largest ? 1 / std::sqrt(H(i, i)) : 1 / std::sqrt(largest);
    H.row(i) *= scale;
    H.col(i) *= scale;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(H);
  VectorXd free = VectorXd::Zero(H.rows());
  for (Eigen::Index k = 0; k < H.rows(); ++k)
    if (solver.eigenvalues()[k] < 1e-8) free += solver.eigenvectors().col(k).cwiseAbs2();
  for (Eigen::Index i = 0; i < free.size(); ++i)
    if (free[i] > 0.05) names.push_back(w.system.velocity_name(int(i)));
  return names;
}

}  // namespace borelli
