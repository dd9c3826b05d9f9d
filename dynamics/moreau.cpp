#include "dynamics/moreau.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/branch_sparse.hpp"
#include "dynamics/impact.hpp"
#include "dynamics/motion_flow.hpp"

namespace borelli {

using Eigen::VectorXd;

namespace {

// gaps below this part of the length of what touches are closed
constexpr double closed_gap = 1e-9;

// a part of the velocities: impulses that change less have settled
constexpr double settled = 1e-10;
constexpr int most_sweeps = 5000;

// of the radii: what goes deeper without acting has gone through, as deep as overlaps are trusted
constexpr double passes = 1e-2;

/// The least gap of two rounded things within half a step before and after now, if they go on as they go: at
/// `speed`, of which `rate` along the line between them.
double least_gap(double gap, double rate, double speed, double radii, double half_step) {
  const double distance = gap + radii;
  // nearest outside the step, or at rest
  if (speed * speed * half_step <= std::abs(rate) * distance) return gap;
  return std::sqrt(std::max(0., 1 - rate * rate / (speed * speed))) * distance - radii;
}

}  // namespace

MoreauStepping::Scratch::Scratch(const System& system)
    : every(system),
      solver(system),
      J(Rows::Zero(3 * Eigen::Index(system.contacts.size()), system.nv)),
      response(J),
      G(Rows::Zero(J.rows(), J.rows())),
      before(VectorXd::Zero(J.rows())),
      free(before),
      velocity(before),
      impulse(before),
      plastic(before),
      driven(before),
      target(VectorXd::Zero(Eigen::Index(system.contacts.size()))),
      wanted(VectorXd::Zero(system.rows)),
      correction(VectorXd::Zero(system.nv)) {
  every.every_row = true;
  acting.reserve(system.contacts.size());
}

/// The contacts that touch or overlap in the middle of the step, with their velocities at its start (y) and
/// those that its end would have without them (out).
void MoreauStepping::find_acting(const MotionFlow& motion, const VectorXd& y, const VectorXd& out, double h,
                                 double least_rebound) {
  const System& system = motion.system();
  const Eigen::Index n = system.nv;
  Scratch& s = *scratch_;
  scan_constraints(system, system.parameters, motion.workspace().kinematics, s.every);
  s.acting.clear();
  for (int i = 0; i < int(system.contacts.size()); ++i) {
    const Contact& contact = system.contacts[i];
    step_.gap[i] = s.every.h[contact.row];
    if (step_.gap[i] > closed_gap * system.row_scale[contact.row]) {
      impulse_.segment<3>(3 * i).setZero();
      const double radii = radii_of(system.parameters.constraints[contact.constraint].kind);
      if (radii > 0)
        step_.gap[i] = least_gap(step_.gap[i], s.every.rate[contact.row],
                                 s.every.rate.segment<3>(contact.row).norm(), radii, 0.5 * h);
      // it went through, or a long thing may have swept over the whole of the other
      if (step_.gap[i] < -passes * radii || 0.5 * h * s.every.speed[contact.row] > step_.gap[i] + radii)
        step_.passed = i;
      continue;
    }
    const Eigen::Index k = 3 * Eigen::Index(s.acting.size());
    for (int c = 0; c < 3; ++c) {
      const bool there = c == 0 || contact.tangents;
      const int row = contact.row + c;
      s.J.row(k + c).setZero();
      if (there) s.J.row(k + c) = s.every.L.row(row).head(n);
      // rates are those of the middle, where the drives are taken
      const double rate = there ? s.every.rate[row] : 0;
      s.driven[k + c] = rate - s.J.row(k + c).dot(middle_.segment(n, n));
      s.before[k + c] = rate + s.J.row(k + c).dot(y.segment(n, n) - middle_.segment(n, n));
      s.free[k + c] = rate + s.J.row(k + c).dot(out.segment(n, n) - middle_.segment(n, n));
    }
    const double speed = s.before[k];
    s.impulse.segment<3>(k) = impulse_.segment<3>(3 * i);
    const double e = surface_of(system.parameters.constraints[contact.constraint].kind).restitution;
    // one that parts already may close again as fast: then its impulse does no work, and it comes no nearer
    s.target[k / 3] = speed < -least_rebound ? -e * speed : std::min(0., -speed);
    s.acting.push_back(i);
  }
}

/// What impulses on the acting contacts do, by the mass matrix in the middle and with the bilateral
/// constraints.
void MoreauStepping::find_response(const MotionFlow& motion) {
  const System& system = motion.system();
  const Workspace& w = motion.workspace();
  Scratch& s = *scratch_;
  s.solver.prepare(w.rows.L, w.factor, true);
  const Eigen::Index rows = 3 * Eigen::Index(s.acting.size());
  for (Eigen::Index r = 0; r < rows; ++r) {
    s.response.row(r) = s.J.row(r);
    solve_transposed(system, w.factor, s.response.row(r).data());
    solve_lower(system, w.factor, s.response.row(r).data());
    if (s.solver.rank() == 0) continue;
    s.wanted.noalias() = -w.rows.L.leftCols(system.nv) * s.response.row(r).transpose();
    s.solver.correct(w.factor, s.wanted, s.correction);
    s.response.row(r) += s.correction.transpose();
  }
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) s.G(i, j) = s.G(j, i) = s.J.row(i).dot(s.response.row(j));
}

/// Sweeps until impulses stay: each contact's normal impulse, then its friction, projected on Coulomb's cone.
/// What the last sweep still changed, in parts of `scale`.
double MoreauStepping::sweep(const System& system, const VectorXd& target, double scale, VectorXd& impulse) {
  Scratch& s = *scratch_;
  const Eigen::Index count = Eigen::Index(s.acting.size()), rows = 3 * count;
  s.velocity.head(rows) = s.free.head(rows);
  for (Eigen::Index r = 0; r < rows; ++r)
    if (impulse[r] != 0) s.velocity.head(rows) += impulse[r] * s.G.row(r).head(rows).transpose();
  double change = 0;
  const auto move = [&](Eigen::Index row, double to) {
    const double by = to - impulse[row];
    if (by == 0) return;
    impulse[row] = to;
    s.velocity.head(rows) += by * s.G.row(row).head(rows).transpose();
    if (const double moved = std::abs(by) * s.G(row, row); moved > change) {
      change = moved;
      s.moved_most = int(row / 3);
    }
  };
  for (int pass = 0; pass < most_sweeps; ++pass) {
    change = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index row = 3 * k;
      if (s.G(row, row) <= 0) continue;
      move(row, std::max(0., impulse[row] - (s.velocity[row] - target[k]) / s.G(row, row)));
      const Contact& contact = system.contacts[s.acting[k]];
      const double across = std::max(s.G(row + 1, row + 1), s.G(row + 2, row + 2));
      const double limit =
          surface_of(system.parameters.constraints[contact.constraint].kind).friction * impulse[row];
      if (across <= 0) continue;
      const Eigen::Vector2d t =
          on_friction_cone(impulse.segment<2>(row + 1) - s.velocity.segment<2>(row + 1) / across, limit);
      move(row + 1, t[0]);
      move(row + 2, t[1]);
    }
    if (change <= settled * scale) break;
  }
  return change / scale;
}

/// Of the impulses over the step, J: with forces that are constant in it, what they change of the energy
/// (Acary, Energy conservation and dissipation properties of time-integration methods for nonsmooth
/// elastodynamics with contact, ZAMM 96, 2016).
double MoreauStepping::work(const VectorXd& impulse) const {
  const Scratch& s = *scratch_;
  const Eigen::Index rows = 3 * Eigen::Index(s.acting.size());
  double sum = 0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    if (impulse[i] == 0) continue;
    double after = s.free[i];
    for (Eigen::Index j = 0; j < rows; ++j) after += s.G(i, j) * impulse[j];
    sum += 0.5 * impulse[i] * (s.before[i] + after);
  }
  return sum;
}

/// Rebounds that would give energy (Newton's can, with several contacts or with friction) are scaled back
/// until they do not.
void MoreauStepping::scale_back(const System& system, double scale) {
  Scratch& s = *scratch_;
  const Eigen::Index count = Eigen::Index(s.acting.size()), rows = 3 * count;
  if (work(s.impulse) <= 0 || s.target.head(count).maxCoeff() <= 0) return;
  s.plastic.head(rows) = s.impulse.head(rows);
  s.target.head(count) = s.target.head(count).cwiseMin(0);
  sweep(system, s.target, scale, s.plastic);
  double low = 0, high = 1;
  s.impulse.head(rows) -= s.plastic.head(rows);  // what the rebound adds
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    s.velocity.head(rows) = s.plastic.head(rows) + middle * s.impulse.head(rows);
    (work(s.velocity) <= 0 ? low : high) = middle;
  }
  s.impulse.head(rows) = s.plastic.head(rows) + low * s.impulse.head(rows);
}

/// The impulses' work; those that met faster than `least_rebound` are impacts.
void MoreauStepping::book(const System& system, double least_rebound) {
  Scratch& s = *scratch_;
  const Eigen::Index rows = 3 * Eigen::Index(s.acting.size());
  for (Eigen::Index k = 0; k < rows; k += 3) {
    const Contact& contact = system.contacts[s.acting[k / 3]];
    double done = 0;
    for (int c = 0; c < 3; ++c) {
      double after = s.free[k + c];
      for (Eigen::Index j = 0; j < rows; ++j) after += s.G(k + c, j) * s.impulse[j];
      done += 0.5 * s.impulse[k + c] * (s.before[k + c] + after);
    }
    step_.group_work[system.constraints[contact.constraint].group] += done;
    if (s.before[k] < -least_rebound && s.impulse[k] > 0) {
      ++step_.impacts;
      step_.impact_loss -= done;
    }
    impulse_.segment<3>(3 * s.acting[k / 3]) = s.impulse.segment<3>(k);
  }
}

/// The work of efforts, drives and moving constraints at the velocity that the impulses leave on the mean,
/// and of drives against the impulses. Without any of these there is none to mend.
bool MoreauStepping::book_powers(Flow& flow, const MotionFlow& motion, double t, double h, const VectorXd& y,
                                 VectorXd& out) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  const Eigen::Index n = system.nv, works = y.size() - 2 * n, drives = 2 * n + 1;
  if (system.parameters.drives.empty() && system.parameters.efforts.empty() &&
      motion.workspace().rows.partial_rate.isZero(0))
    return true;
  s.moved = middle_;
  s.moved.segment(n, n) += 0.5 * s.correction;
  if (!flow.derivative(t + 0.5 * h, s.moved, s.slope)) return false;
  out.tail(works) = y.tail(works) + h * s.slope.tail(works);
  for (Eigen::Index r = 0; r < 3 * Eigen::Index(s.acting.size()); ++r) {
    const double done = -s.impulse[r] * s.driven[r];
    out[drives] += done;
    out[2 * n + 4 + system.constraints[system.contacts[s.acting[r / 3]].constraint].group] += done;
  }
  return true;
}

Attempt MoreauStepping::attempt(Flow& flow, double t, double h, const VectorXd& y, const VectorXd& dy,
                                VectorXd& out) {
  slope_.resize(y.size());
  middle_ = y + 0.5 * h * dy;
  if (!flow.derivative(t + 0.5 * h, middle_, slope_)) return {.evaluated = false, .next_step = h};
  out = y + h * slope_;
  const MotionFlow* motion = flow.motion();
  if (!motion || motion->system().contacts.empty()) return {.next_step = h};
  const System& system = motion->system();
  const Eigen::Index n = system.nv;
  if (!scratch_) {
    scratch_ = std::make_unique<Scratch>(system);
    if (impulse_.size() == 0) impulse_ = VectorXd::Zero(3 * Eigen::Index(system.contacts.size()));
    step_.gap = VectorXd::Zero(Eigen::Index(system.contacts.size()));
    step_.group_work = VectorXd::Zero(system.groups);
  }
  Scratch& s = *scratch_;
  step_.group_work.setZero();
  step_.impacts = 0;
  step_.passed = -1;
  step_.impact_loss = step_.unsettled = 0;
  const double fall = system.parameters.gravity.norm() * h;  // what gravity makes of a velocity in the step
  find_acting(*motion, y, out, h, fall);
  const Eigen::Index rows = 3 * Eigen::Index(s.acting.size());
  step_.acted = rows > 0;
  if (!step_.acted) return {.next_step = h};
  find_response(*motion);
  const double scale = std::max(
      {fall, s.before.head(rows).cwiseAbs().maxCoeff(), s.free.head(rows).cwiseAbs().maxCoeff(), 1e-300});
  step_.unsettled = sweep(system, s.target, scale, s.impulse);
  step_.unsettled_contact = s.acting[s.moved_most];
  scale_back(system, scale);
  book(system, fall);
  // velocities, and the half step of the positions that the jump is there for
  s.correction.setZero();
  for (Eigen::Index r = 0; r < rows; ++r)
    if (s.impulse[r] != 0) s.correction += s.impulse[r] * s.response.row(r).transpose();
  out.segment(n, n) += s.correction;
  s.moved = middle_;
  s.moved.segment(n, n) = s.correction;
  s.slope.resize(y.size());
  flow.position_rate(s.moved, s.slope);
  out.head(n) += 0.5 * h * s.slope.head(n);
  return {.evaluated = book_powers(flow, *motion, t, h, y, out), .next_step = h};
}

bool MoreauStepping::shortened(Flow& flow, double t, double h, const VectorXd& y, const VectorXd& dy,
                               VectorXd& out) {
  kept_step_ = step_;
  kept_impulse_ = impulse_;
  const bool evaluated = attempt(flow, t, h, y, dy, out).evaluated;
  step_ = kept_step_;
  impulse_ = kept_impulse_;
  return evaluated;
}

}  // namespace borelli
