#include "dynamics/equations/reaction.hpp"

#include <fmt/format.h>

#include <Eigen/LU>

#include "dynamics/equations/equations.hpp"
#include "dynamics/system/border.hpp"

namespace borelli {

using Eigen::Vector3d;

namespace {

// Rank tolerance for unit rows, as ConstraintSolver::rank_tolerance.
constexpr double dependence = 1e-8;
// Self-stress of unit multipliers that loads a joint by less is rounding, N or N m.
constexpr double no_load = 1e-9;

void add_at(const Wrench<double>& wrench, const Vector3d& arm, Wrench<double>& to) {
  to.f += wrench.f;
  to.n += wrench.n + arm.cross(wrench.f);
}

}  // namespace

Result<Reactions> Reactions::of(const Scene& scene) {
  auto system = compile(scene, Welds::kept);
  if (!system) return tl::unexpected(system.error());
  const System& kept = *system;
  return at_border(kept, [&]() -> Result<Reactions> {
    if (auto fits = admit_workspaces(kept, Equations::recursive, 1, false); !fits)
      return tl::unexpected(fits.error());
    Reactions out(std::move(*system));
    for (const Solid& solid : scene.solids) out.parents_.push_back(solid.parent);
    return out;
  });
}

Reactions::Reactions(System system)
    : system_(std::make_shared<const System>(std::move(system))),
      kinematics_(*system_, Equations::recursive),
      efforts_(*system_),
      rows_(*system_),
      recursion_(*system_),
      terms_(*system_, false),
      wrenches_(system_->bodies.size()) {
  rows_.every_row = true;
}

/// Adds the constraint forces of these multipliers to the efforts on the bodies.
void Reactions::load(const Eigen::VectorXd& multipliers) {
  if (system_->rows == 0) return;
  rows_.loads = {&multipliers, &efforts_};
  scan_constraints(*system_, system_->parameters, kinematics_, rows_);
  rows_.loads = {};
}

/// From the leaves to the root: the wrench that each body needs from its parent.
void Reactions::find_wrenches() {
  const System& s = *system_;
  for (std::size_t b = 1; b < s.bodies.size(); ++b)
    wrenches_[b] = {recursion_.inertia[b].n - recursion_.applied[b].n,
                    recursion_.inertia[b].f - recursion_.applied[b].f};
  for (std::size_t b = s.bodies.size() - 1; b > 0; --b) {
    const int parent = s.bodies[b].parent;
    if (parent > 0)
      add_at(wrenches_[b], kinematics_.bodies[b].X.p - kinematics_.bodies[parent].X.p, wrenches_[parent]);
  }
}

std::vector<JointReaction> Reactions::at(const State& state, const Eigen::VectorXd& a,
                                         const Eigen::VectorXd& multipliers,
                                         const std::vector<Touch>& touches) {
  const System& s = *system_;
  const Parameters& p = s.parameters;
  update_kinematics<double>(s, p, p.inertials, state.t, state.q.data(), state.v.data(), a.data(),
                            kinematics_);
  scan_efforts(s, p, kinematics_, efforts_);
  load(multipliers);
  find_own_forces(s, p, p.inertials, kinematics_, efforts_, recursion_, terms_);
  find_wrenches();
  std::vector<JointReaction> out(s.solids.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto b = std::size_t(s.solid_bodies[i]);
    const Pose& X = kinematics_.bodies[b].X;
    JointReaction& r = out[i];
    r.point = s.bodies[b].step_count > 0 ? X.p : Vector3d(X * p.solid_places[i].X.p);
    r.force = wrenches_[b].f;
    r.moment = wrenches_[b].n + (X.p - r.point).cross(wrenches_[b].f);
    const int parent = s.bodies[b].parent;
    r.R_WP = kinematics_.bodies[std::size_t(parent)].X.R;
    if (parent > 0) r.R_WP *= p.solid_places[std::size_t(s.bodies[std::size_t(parent)].solids[0])].X.R;
  }
  if (s.rows > 0) find_unique(touches, out);
  return out;
}

/// Finds self-stresses, constraint loads that balance each other (L^T z = 0). A joint that such a load passes
/// through has no unique reaction.
void Reactions::find_unique(const std::vector<Touch>& touches, std::vector<JointReaction>& out) {
  const System& s = *system_;
  std::vector<char> holds(std::size_t(s.rows), 1);
  for (std::size_t i = 0; i < s.contacts.size(); ++i) {
    const Touch touch = touches.empty() ? Touch::open : touches[i];
    const int count = s.contacts[i].tangents ? 3 : 1, kept = touch == Touch::sticking  ? count
                                                             : touch == Touch::sliding ? 1
                                                                                       : 0;
    for (int r = kept; r < count; ++r) holds[std::size_t(s.contacts[i].row + r)] = 0;
  }
  std::vector<int> rows;
  for (int r = 0; r < s.rows; ++r)
    if (holds[std::size_t(r)]) rows.push_back(r);
  if (rows.empty()) return;
  Eigen::MatrixXd units = Eigen::MatrixXd::Zero(std::max(s.nv, 1), Eigen::Index(rows.size()));
  std::vector<double> lengths;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = rows_.L.row(rows[i]).head(s.nv);
    lengths.push_back(row.norm() > 0 ? row.norm() : 1);
    units.col(Eigen::Index(i)).head(s.nv) = row.transpose() / lengths.back();
  }
  Eigen::FullPivLU<Eigen::MatrixXd> lu(units);
  lu.setThreshold(dependence);
  if (lu.dimensionOfKernel() == 0) return;
  const Eigen::MatrixXd kernel = lu.kernel();
  for (Eigen::Index k = 0; k < kernel.cols(); ++k) {
    Eigen::VectorXd z = Eigen::VectorXd::Zero(s.rows);
    for (std::size_t i = 0; i < rows.size(); ++i)
      z[rows[i]] = kernel(Eigen::Index(i), k) / kernel.col(k).norm() / lengths[i];
    for (std::size_t b = 1; b < s.bodies.size(); ++b) {
      efforts_.force[b].setZero();
      efforts_.moment[b].setZero();
      recursion_.inertia[b] = {};
    }
    load(z);
    for (std::size_t b = 1; b < s.bodies.size(); ++b) {
      if (!s.bodies[b].touched) continue;
      const Vector3d arm = kinematics_.bodies[b].g - kinematics_.bodies[b].X.p;
      recursion_.applied[b] = {efforts_.moment[b] + arm.cross(efforts_.force[b]), efforts_.force[b]};
    }
    find_wrenches();
    for (std::size_t i = 0; i < out.size(); ++i) {
      const auto& w = wrenches_[std::size_t(s.solid_bodies[i])];
      if (w.f.norm() > no_load || w.n.norm() > no_load * std::max(1.0, s.length)) out[i].unique = false;
    }
  }
}

Result<void> add_reactions(const Scene& scene, Trajectory& t) {
  if (t.certificate.method == "moreau" && !t.contact_names.empty())
    return bad_use("reactions",
                   "cannot be computed for a run with moreau, whose contacts act by impulses and not through "
                   "accelerations; choose another method");
  auto reactions = Reactions::of(scene);
  if (!reactions) return tl::unexpected(reactions.error());
  return at_border(reactions->system(), [&] { return reactions->add_to(t); });
}

Result<void> Reactions::add_to(Trajectory& t) {
  const auto rows = Eigen::Index(t.times.size());
  const auto joints = Eigen::Index(solids().size());
  if (auto fits =
          admit_large(*system_, sizeof(double) * 10.0 * double(rows) * double(joints),
                      [&] { return fmt::format("the reactions of {} joints at {} times", joints, rows); });
      !fits)
    return fits;
  t.reaction_points = t.reaction_forces = t.reaction_moments = Rows::Zero(rows, 3 * joints);
  t.reaction_unique = Rows::Ones(rows, joints);
  State state;
  std::vector<Touch> touches(std::size_t(t.contact_modes.cols()));
  for (Eigen::Index row = 0; row < rows; ++row) {
    state.t = t.times[std::size_t(row)];
    state.q = t.q.row(row);
    state.v = t.v.row(row);
    for (std::size_t i = 0; i < touches.size(); ++i)
      touches[i] = static_cast<Touch>(int(t.contact_modes(row, Eigen::Index(i))));
    const auto found = at(state, t.a.row(row), t.multipliers.row(row), touches);
    for (Eigen::Index j = 0; j < joints; ++j) {
      const JointReaction& r = found[std::size_t(j)];
      t.reaction_points.row(row).segment<3>(3 * j) = r.point;
      t.reaction_forces.row(row).segment<3>(3 * j) = r.force;
      t.reaction_moments.row(row).segment<3>(3 * j) = r.moment;
      t.reaction_unique(row, j) = r.unique ? 1 : 0;
    }
  }
  return {};
}

}  // namespace borelli
