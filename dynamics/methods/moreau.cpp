// Moreau's time stepping: the step, and which contacts act in it. For the effect of the impulses see
// moreau_impulses.cpp.
#include "dynamics/methods/moreau.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/methods/motion_flow.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/numbers/processor.hpp"

namespace borelli {

using Eigen::VectorXd;

namespace {

// A contact is closed if its gap is below this fraction of the length scale.
constexpr double closed_gap = 1e-9;

// Initial room for acting contacts; doubled as needed.
constexpr int usual_acting = 32;

// Impulses may close further contacts, which then act too: the most rounds of this in a step.
constexpr int most_rounds = 6;

// Relative to the radii: bodies that overlap deeper without acting have passed through each other. As deep as
// overlaps are trusted.
constexpr double passes = 1e-2;

/// Smallest gap of two round bodies within half a step before and after now, in uniform motion: relative
/// `speed`, with component `rate` along the line of centres.
double least_gap(double gap, double rate, double speed, double radii, double half_step) {
  const double distance = gap + radii;
  // The closest approach is outside the step, or the bodies are at relative rest.
  if (speed * speed * half_step <= std::abs(rate) * distance) return gap;
  return std::sqrt(std::max(0., 1 - rate * rate / (speed * speed))) * distance - radii;
}

/// Copies three rows of n numbers to columns of J (whose rows have `stride` numbers) and multiplies them with
/// the columns of `motions` (n x 4).
BORELLI_INLINED_FOR_PROCESSOR
void take_directions(const double* const rows[3], const double* motions, int n, double* J,
                     Eigen::Index stride, Quad products[3]) {
  Quad sums[3] = {Quad(0), Quad(0), Quad(0)};
  for (int d = 0; d < n; ++d, J += stride) {
    const Quad motion = Quad::load(motions + Quad::count * d);
    for (int c = 0; c < 3; ++c) {
      J[c] = rows[c][d];
      sums[c] += rows[c][d] * motion;
    }
  }
  for (int c = 0; c < 3; ++c) products[c] = sums[c];
}

}  // namespace

MoreauStepping::Scratch::Scratch(const System& system, Equations equations)
    : at(system, equations),
      seen(system),
      end(system),
      far(system),
      rows(system),
      landed(system, equations),
      links(system),
      acts(system.contacts.size()),
      known(system.constraints.size()),
      wanted(VectorXd::Zero(system.rows)),
      x(VectorXd::Zero(system.nv)),
      change(x),
      shift(x),
      motions(RowsOf<double>::Zero(system.nv, Quad::count)),
      nothing(x),
      state(system.initial),
      work(system.groups) {
  at.leaves_contacts = true;
  seen.detail = ConstraintRows::Detail::rates;
  end.detail = ConstraintRows::Detail::values;
  seen.far.resize(system.constraints.size());
  end.far = seen.far;
  reserve(std::min(int(system.contacts.size()), usual_acting));
  acting.reserve(system.contacts.size());
}

void MoreauStepping::Scratch::reserve(int contacts) {
  if (contacts <= late.size()) return;
  const Eigen::Index directions =
      (3 * Eigen::Index(contacts) + Lanes::count - 1) / Lanes::count * Lanes::count;
  J.conservativeResizeLike(Rows::Zero(x.size(), directions));
  Y.resize(x.size(), directions);
  touched.resize(std::size_t(directions / Lanes::count * (1 + x.size())));
  problem.G.setZero(directions, directions);
  for (VectorXd* of_rows : {&before, &impulse, &plastic, &driven, &problem.free})
    of_rows->conservativeResizeLike(VectorXd::Zero(directions));
  for (VectorXd* of_contacts : {&late, &ends, &apart, &problem.target})
    of_contacts->conservativeResizeLike(VectorXd::Zero(contacts));
  problem.friction.resize(std::size_t(contacts));
}

/// The gaps of all contacts at the state y.
void MoreauStepping::find_gaps(const MotionFlow& motion, double t, const VectorXd& y) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  motion.take(y, s.state, s.work);
  const double *q = s.state.q.data(), *v = s.state.v.data();
  if (s.landed.equations == Equations::recursive && s.links.every_body_moves) {
    const Parameters& p = system.parameters;
    move_links<double>(system, p, p.inertials, t, q, v, nullptr, s.landed, s.links);
    find_bodies<double>(system, p, p.inertials, s.landed, s.links);
  } else {
    update_kinematics(system, system.parameters, t, q, v, s.landed);
  }
  s.far.mark(s.landed, 0, 0, s.end);
  scan_constraints(system, system.parameters, s.landed, s.end);
}

/// The rows of a contact; `kinematics` holds the motion of its bodies.
void MoreauStepping::find_rows(const System& system, const Kinematics& kinematics, int contact) {
  Scratch& s = *scratch_;
  const int i = system.contacts[contact].constraint;
  if (s.known[i]) return;
  scan_constraint(system, system.parameters, kinematics, i, s.rows);
  s.known[i] = 1;
}

/// Finds the contacts that the step would close, and the mass matrix at its middle. Returns false if it is
/// singular.
bool MoreauStepping::find_acting(const MotionFlow& motion, double t, double h) {
  const System& system = motion.system();
  const Eigen::Index n = system.nv;
  Scratch& s = *scratch_;
  s.acting.clear();
  std::fill(s.acts.begin(), s.acts.end(), 0);
  s.far.mark(motion.workspace().kinematics, 0.5 * h, h * fall_, s.seen);
  scan_constraints(system, system.parameters, motion.workspace().kinematics, s.seen);
  bool ready = false;
  for (int i = 0; i < int(system.contacts.size()); ++i) {
    const Contact& contact = system.contacts[i];
    const double gap = s.seen.h[contact.row];
    const double speed =
        contact.tangents ? s.seen.rate.segment<3>(contact.row).norm() : std::abs(s.seen.rate[contact.row]);
    // Contacts that approach faster than their present rate are found at the step's end.
    if (gap > 0.5 * h * speed + h * fall_) continue;
    if (!ready && !ready_response(motion, t, h)) return false;
    ready = true;
    find_rows(system, s.at.kinematics, i);
    const double after = s.rows.rate[contact.row] + 0.25 * h * s.rows.E[contact.row] +
                         s.rows.L.row(contact.row).head(n).dot(s.motions.col(2));
    // A contact that acted in the last step is kept while it is near: impulses of others may close it again.
    const double ends = gap + 0.5 * h * after;
    if (ends <= closed_gap * system.row_scale[contact.row] || (step_.impulse[3 * i] > 0 && ends <= h * fall_))
      add_acting(system, i, h);
  }
  return true;
}

/// Adds contacts that overlap at the step's end without acting. Returns false if the mass matrix is singular.
bool MoreauStepping::add_overlapping(const MotionFlow& motion, double t, double h, bool& added) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  added = false;
  for (int i = 0; i < int(system.contacts.size()); ++i) {
    const Contact& contact = system.contacts[i];
    if (s.acts[i] || s.end.h[contact.row] >= -closed_gap * system.row_scale[contact.row]) continue;
    if (s.acting.empty() && !ready_response(motion, t, h)) return false;
    find_rows(system, s.at.kinematics, i);
    add_acting(system, i, h);
    added = true;
  }
  return true;
}

/// Mass matrix and bilateral rows at the middle of the step. Returns false if the mass matrix is singular.
bool MoreauStepping::ready_response(const MotionFlow& motion, double t, double h) {
  const System& system = motion.system();
  Scratch& s = *scratch_;
  motion.take(middle_, s.state, s.work);
  std::fill(s.known.begin(), s.known.end(), 0);
  if (update_terms(system, system.parameters, t + 0.5 * h, s.state.q.data(), s.state.v.data(), s.at))
    return false;
  if (s.at.has_rows()) s.at.solver.prepare(s.at.rows.L, s.at.factor, true);
  return true;
}

/// Adds an acting contact with its velocities at the step's start and, without impulses, at the end. The rows
/// of its constraint must be known.
void MoreauStepping::add_acting(const System& system, int i, double h) {
  const Eigen::Index n = system.nv;
  Scratch& s = *scratch_;
  const Contact& contact = system.contacts[i];
  const int number = int(s.acting.size()), k = 3 * number;
  if (number == s.late.size()) s.reserve(std::min(2 * number, int(system.contacts.size())));
  const double* each[3];
  for (int c = 0; c < 3; ++c)
    each[c] = c > 0 && !contact.tangents ? s.nothing.data() : &s.rows.L(contact.row + c, 0);
  Quad along[3];
  take_directions(each, s.motions.data(), int(n), &s.J(0, k), s.J.cols(), along);
  for (int c = 0; c < 3; ++c) {
    const int row = contact.row + c;
    if (c > 0 && !contact.tangents) {
      s.driven[k + c] = s.before[k + c] = s.problem.free[k + c] = 0;
      continue;
    }
    // Rates at the middle, where the drives are evaluated.
    const double rate = s.rows.rate[row];
    // Change of the rates over half a step because the rows turn.
    const double turns = 0.5 * h * s.rows.E[row];
    s.driven[k + c] = rate - along[c][0];
    s.before[k + c] = rate - turns + along[c][1];
    s.problem.free[k + c] = rate + turns + along[c][2];
  }
  const double speed = s.before[k], after = s.problem.free[k];
  const ContactSurface surface = surface_of(system.parameters.constraints[contact.constraint].kind);
  s.impulse.segment<3>(k) = step_.impulse.segment<3>(3 * i);
  // The gap at the end without impulses; a resting contact's impulse moves the bodies for half of the step.
  const double ends = s.rows.h[contact.row] + 0.5 * h * (after - 0.25 * h * s.rows.E[contact.row]);
  const bool is_near = ends > closed_gap * system.row_scale[contact.row];
  s.problem.target[number] = speed < -fall_ ? -surface.restitution * speed
                             : is_near      ? std::min(0., after - 2 * ends / h)
                                            : 0;
  s.problem.friction[number] = surface.friction;
  s.ends[number] = ends;
  s.late[number] = speed < -fall_ && after < 0 ? std::clamp(ends / (h * after), 0., 1.) : 0.5;
  s.acting.push_back(i);
  s.acts[i] = 1;
  s.problem.count = number + 1;
}

/// Errors of the acting contacts' gaps: deviation from a straight path, and overlap.
void MoreauStepping::judge_paths(const System& system, double h, bool sudden) {
  Scratch& s = *scratch_;
  const Eigen::Index rows = 3 * Eigen::Index(s.problem.count);
  step_.bent.setZero();
  step_.overlap.setZero();
  for (Eigen::Index k = 0; k < rows; k += 3) {
    const int i = s.acting[k / 3];
    const auto response = s.problem.G.row(k).head(rows);
    const double moved =
        sudden ? response.dot(s.plastic.head(rows)) : 0.5 * h * response.dot(s.impulse.head(rows));
    const double gap = s.end.h[system.contacts[i].row];
    step_.bent[i] = std::abs(gap - s.ends[k / 3] - moved);
    step_.overlap[i] = std::max(0., -gap);
  }
}

/// Gaps for the certificate, and contacts that bodies may have passed through.
void MoreauStepping::judge_gaps(const System& system, double h) {
  Scratch& s = *scratch_;
  for (int i = 0; i < int(system.contacts.size()); ++i) {
    const Contact& contact = system.contacts[i];
    step_.gap[i] = s.end.h[contact.row];
    if (s.acts[i] || s.seen.far[contact.constraint]) continue;
    const double radii = radii_of(system.parameters.constraints[contact.constraint].kind);
    const double gap = s.seen.h[contact.row];
    const double least = radii > 0 ? least_gap(gap, s.seen.rate[contact.row],
                                               s.seen.rate.segment<3>(contact.row).norm(), radii, 0.5 * h)
                                   : gap;
    // The bodies passed through each other, or a long body may have swept over the whole of the other.
    if ((radii > 0 && least < -passes * radii) ||
        0.5 * h * s.seen.speed[contact.row] > std::max(0., least) + radii)
      step_.passed = i;
    step_.gap[i] = std::min(step_.gap[i], least);
  }
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
  if (!scratch_) {
    scratch_ = std::make_unique<Scratch>(system, motion->workspace().kinematics.equations);
    if (step_.impulse.size() == 0)  // otherwise it comes from a checkpoint
      step_.impulse = VectorXd::Zero(3 * Eigen::Index(system.contacts.size()));
    step_.gap = step_.bent = step_.overlap = VectorXd::Zero(Eigen::Index(system.contacts.size()));
    step_.group_work = step_.group_shift = step_.group_projection = VectorXd::Zero(system.groups);
  }
  return {.evaluated = meet(flow, *motion, t, h, y, out), .next_step = h};
}

/// Adds the contacts to a step; `out` is its end without them. Returns false if the equations cannot be
/// solved.
bool MoreauStepping::meet(Flow& flow, const MotionFlow& motion, double t, double h, const VectorXd& y,
                          VectorXd& out) {
  const System& system = motion.system();
  const Eigen::Index n = system.nv;
  Scratch& s = *scratch_;
  if (step_.length > 0) step_.impulse *= h / step_.length;  // initial guess: resting contacts
  step_.length = h;
  step_.group_work.setZero();
  step_.group_shift.setZero();
  step_.group_projection.setZero();
  step_.impacts = 0;
  step_.passed = -1;
  step_.impact_loss = step_.unsettled = 0;
  fall_ = system.parameters.gravity.norm() * h;
  s.problem.count = 0;
  s.motions.leftCols<3>() << middle_.segment(n, n), y.segment(n, n) - middle_.segment(n, n),
      out.segment(n, n) - middle_.segment(n, n);
  if (!find_acting(motion, t, h)) return false;
  landed_ = out;
  bool sudden = false;  // some impulse does not act over the whole step
  for (int round = 0; round < most_rounds; ++round) {
    if (s.problem.count > 0) {
      const int rows = 3 * s.problem.count;
      find_response(system, rows);
      const double scale = std::max({fall_, s.before.head(rows).cwiseAbs().maxCoeff(),
                                     s.problem.free.head(rows).cwiseAbs().maxCoeff(), 1e-300});
      step_.unsettled = s.solver.solve(s.problem, scale, s.impulse, ContactStep::most_unsettled);
      step_.unsettled_contact = s.acting[s.solver.worst()];
      scale_back(scale);
      respond(system, s.impulse, rows, s.change);
      sudden = false;
      for (int k = 0; k < s.problem.count; ++k) {
        sudden = sudden || (s.late[k] != 0.5 && s.impulse[3 * k] > 0);
        s.plastic.segment<3>(3 * k) = h * s.late[k] * s.impulse.segment<3>(3 * k);
      }
      if (sudden)
        respond(system, s.plastic, rows, s.shift);
      else
        s.shift = 0.5 * h * s.change;
      landed_ = out;
      landed_.segment(n, n) += s.change;
      move(flow, s.shift, landed_);
    }
    find_gaps(motion, t + h, landed_);
    bool added = false;
    if (!add_overlapping(motion, t, h, added)) return false;
    if (!added) break;
  }
  judge_paths(system, h, sudden);
  step_.acted = s.problem.count > 0;
  step_.impulse.setZero();
  if (step_.acted) {
    book(system);
    // Before energies are evaluated, which overwrite the factor of the mass matrix.
    const bool apart = separate(flow, motion, t + h);
    if (sudden) {
      s.shift = 0.5 * h * s.change;
      move(flow, s.shift, out);
      if (!book_move(motion, t + h, out, landed_, step_.group_shift)) return false;
      step_.group_work += step_.group_shift;
    }
    out = landed_;
    if (apart) {
      out = separated_;
      if (!book_move(motion, t + h, landed_, out, step_.group_projection)) return false;
    }
    if (!book_powers(flow, motion, t, h, y, out)) return false;
  }
  judge_gaps(system, h);
  return true;
}

bool MoreauStepping::shortened(Flow& flow, double t, double h, const VectorXd& y, const VectorXd& dy,
                               VectorXd& out) {
  kept_step_ = step_;
  const bool evaluated = attempt(flow, t, h, y, dy, out).evaluated;
  step_ = kept_step_;
  return evaluated;
}

}  // namespace borelli
