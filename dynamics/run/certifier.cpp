#include "dynamics/run/certifier.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>

namespace borelli {

namespace {

// Fraction of the length scale: a deeper overlap, before its removal, may have passed through. (A hundredth
// is trusted.)
constexpr double goes_through = 0.1;

// Fraction of a run's allowed error that one step may use; otherwise it is divided.
constexpr double own_part = 0.05;

}  // namespace

std::string vouches_for(const Certificate& c) {
  if (c.method == captured_method) return "nothing: the motion was recorded, not computed";
  const std::string kept = "energy, momenta and constraints";
  if (std::isnan(c.known_until)) return kept + ", not the state: set an accuracy to bound its error";
  return fmt::format("{}, and the state to {:.3g} up to t = {:.6g} s{}", kept, c.accuracy, c.known_until,
                     c.estimated_error <= c.accuracy ? "" : " only");
}

double energy_threshold(const SimulationSettings& settings, bool adaptive, bool steps_contacts) {
  if (settings.energy_threshold > 0) return settings.energy_threshold;
  // Fixed steps promise no accuracy. A thousandth is too small to see; first-order impacts need a hundredth.
  // The errors of adaptive steps accumulate their tolerances.
  if (steps_contacts) return 1e-2;
  return adaptive ? std::clamp(1e3 * settings.tolerance, 1e-9, 1e-3) : 1e-3;
}

Certifier::Certifier(const System& system, const Parameters& parameters, double threshold,
                     const Assembly& assembly)
    : system_(system),
      parameters_(parameters),
      groups_(system.groups),
      residual_rows_(system.constraints.size()),
      singular_(system),
      step_watch_(system) {
  certificate_.energy_threshold = threshold;
  certificate_.constraint_rows = system.bilateral_rows();
  certificate_.contacts = int(system.contacts.size());
  certificate_.constraint_rank = assembly.rank;
  certificate_.redundant = assembly.redundant;
  note_assembly(assembly);
  for (std::size_t b = 0; b < system.bodies.size(); ++b)
    groups_[system.bodies[b].group].mass += parameters.inertials[b].mass;
  for (const std::string& name : system.constraint_names) {
    certificate_.residuals.emplace_back();
    certificate_.residuals.back().constraint = name;
  }
  for (ConservedMomentum& momentum : conserved_momenta(system, parameters)) {
    certificate_.conserved.emplace_back();
    certificate_.conserved.back().name = momentum.name;
    momenta_.push_back({std::move(momentum)});
  }
}

void Certifier::observe(const State& state, Workspace& workspace, const Work& work) {
  observe_energy(state.t, workspace, work);
  observe_momenta(state.t, workspace);
  observe_residuals(state.t, state, workspace);
  if (const auto reason = singular_.observe(state, workspace, events())) distrust(state.t, *reason);
  started_ = true;
  last_time_ = state.t;
}

void Climb::observe(double t, double value) {
  if (value <= largest_) return;
  largest_ = value;
  time_ = t;
  // Stored coarsely, to find later when a limit was first passed.
  if (steps_.empty()) steps_.reserve(32);
  if (steps_.empty() || value > 1.01 * steps_.back().second) steps_.emplace_back(t, value);
}

double Climb::since(double limit) const {
  for (const auto& [t, past] : steps_)
    if (past > limit) return t;
  return time_;
}

void EnergyBalance::observe(double t, double kinetic, double potential, double work, double row_work) {
  if (!started_) {
    started_ = true;
    start_ = kinetic + potential;
    potential_low_ = potential_high_ = potential;
  }
  largest_kinetic_ = std::max(largest_kinetic_, kinetic);
  potential_low_ = std::min(potential_low_, potential);
  potential_high_ = std::max(potential_high_, potential);
  work_low_ = std::min(work_low_, work);
  work_high_ = std::max(work_high_, work);
  rounding = std::max(rounding, 1e-12 * std::max({kinetic, std::abs(potential), std::abs(work)}));
  off_ = kinetic + potential - work - start_;
  drift.observe(t, std::abs(off_));
  without_row_work.observe(t, std::abs(off_ + row_work));
}

double EnergyBalance::turnover() const {
  return std::max({largest_kinetic_, potential_high_ - potential_low_, work_high_ - work_low_});
}

void Certifier::observe_energy(double t, const Workspace& workspace, const Work& work) {
  const LagrangeTerms& terms = workspace.terms;
  energy_.observe(t, terms.kinetic, terms.potential, work.total(), work.row_work());
  for (int g = 0; g < system_.groups; ++g) {
    EnergyBalance& energy = groups_[g].energy;
    energy.observe(t, terms.group_kinetic[g], terms.group_potential[g], work.groups[g].total(),
                   work.groups[g].row_work());
    energy.projected.observe(t, work.groups[g].projection_size);
  }
}

std::string Certifier::group_words(int group) const {
  return fmt::format("'{}' and the solids tied to it", system_.group_name(group));
}

/// The energy, J, that a group's drift is relative to: its turnover, or with contacts that the method treats
/// itself at least its weight times its length. (A group at rest has no turnover, yet each step stops a small
/// fall.)
double Certifier::energy_scale(int group) const {
  const Group& of = groups_[group];
  return std::max(of.energy.turnover(), of.mass * parameters_.gravity.norm() * of.touching);
}

/// The energy, J, that projections move because of rounding in balanced forces: some units in the last place
/// of a free fall over each step.
double Certifier::rounding_of_rest(int group) const {
  return 16 * std::numeric_limits<double>::epsilon() * groups_[group].mass *
         parameters_.gravity.squaredNorm() * step_squares_;
}

/// Judges each independent group by its own energy, so that a heavy group cannot hide the error of a light
/// one; names the worst.
void Certifier::judge_energy(const Work& work) {
  const double limit = certificate_.energy_threshold;
  int worst = -1, moved = -1;
  double worst_excess = 1, moved_excess = 1;
  bool without_row_work = false;
  const auto allowed = [&](int g) { return std::max(limit * energy_scale(g), groups_[g].energy.rounding); };
  for (int g = 0; g < system_.groups; ++g) {
    const EnergyBalance& energy = groups_[g].energy;
    const Climb& drift = energy.judged(allowed(g));
    without_row_work = without_row_work || &drift == &energy.without_row_work;
    if (drift.largest() > worst_excess * allowed(g)) {
      worst = g;
      worst_excess = drift.largest() / allowed(g);
    }
    const double movable = std::max(limit * energy_scale(g), energy.rounding + rounding_of_rest(g));
    if (work.groups[g].projection_size > moved_excess * movable) {
      moved = g;
      moved_excess = work.groups[g].projection_size / movable;
    }
  }
  if (worst >= 0) {
    const Climb& drift = groups_[worst].energy.judged(allowed(worst));
    const double turnover = energy_scale(worst), since = drift.since(allowed(worst));
    distrust(since, fmt::format("the energy balance of {} has an error of {:.3g} J at t = {:.6g} s, {:.2g} "
                                "of the {:.3g} J turned over (limit {:.2g}, exceeded at t = {:.6g} s)",
                                group_words(worst), drift.largest(), drift.time(), drift.largest() / turnover,
                                turnover, limit, since));
  } else if (without_row_work) {
    note(
        fmt::format("the energy judgement leaves out the work of constraint rows: without it energy drifts "
                    "by {:.2g} J, with it by {:.2g} J",
                    energy_.without_row_work.largest(), energy_.drift.largest()));
    certificate_.energy_drift = energy_.without_row_work.largest();
    certificate_.energy_drift_time = energy_.without_row_work.time();
  }
  if (moved >= 0) {
    const double size = work.groups[moved].projection_size, turnover = energy_scale(moved);
    const double since = groups_[moved].energy.projected.since(limit * turnover);
    const Group& group = groups_[moved];
    distrust(
        since,
        fmt::format(
            "projections onto the constraints of {} changed energy by {:.3g} J in all, {:.2g} of the {:.3g} "
            "J turned over (limit {:.2g}, exceeded at t = {:.6g} s){}",
            group_words(moved), size, size / turnover, turnover, limit, since,
            group.moved_row < 0
                ? ""
                : fmt::format(
                      "; the largest change came at t = {:.6g} s, where row '{}' had the largest residual",
                      group.moved_time, system_.row_names[group.moved_row])));
  }
}

void Certifier::observe_momenta(double t, Workspace& workspace) {
  for (std::size_t i = 0; i < momenta_.size(); ++i) {
    Followed& followed = momenta_[i];
    const MomentumValue now = momentum_value(followed.momentum, parameters_, workspace.kinematics);
    if (!started_) followed.start = now.value;
    followed.last = now.value;
    Conserved& conserved = certificate_.conserved[i];
    conserved.scale = std::max(conserved.scale, now.scale);
    followed.rounding = std::max(followed.rounding, now.rounding);
    const double drift = (now.value - followed.start).norm();
    if (drift <= conserved.drift) continue;
    conserved.drift = drift;
    conserved.time = t;
  }
}

void Certifier::pass_event(Workspace& workspace, bool own) {
  singular_.pass_event();
  if (!own) return;
  for (Followed& followed : momenta_)
    followed.start +=
        momentum_value(followed.momentum, parameters_, workspace.kinematics).value - followed.last;
}

void Certifier::observe_residuals(double t, const State& state, const Workspace& workspace) {
  for (int i = 0; i < system_.nv; ++i) {
    double& speed = groups_[system_.velocity_groups[i]].largest_speed;
    speed = std::max(speed, std::abs(state.v[i]));
  }
  if (!workspace.has_rows()) return;
  for (int row = 0; row < system_.rows; ++row) {
    ConstraintResidual& residual = certificate_.residuals[system_.row_constraint[row]];
    ResidualRows& rows = residual_rows_[system_.row_constraint[row]];
    if (const double h = std::abs(workspace.rows.h[row]); h > residual.position) {
      residual.position = h;
      residual.position_time = t;
      rows.position = row;
      if (!rows.reported && h > certificate_.energy_threshold * system_.row_scale[row]) {
        rows.reported = true;
        // A row that drifts depends on no others.
        if (const auto behind = workspace.solver.rows_behind(row); !behind.empty())
          rows.contradicted = fmt::format("; it contradicts '{}'", fmt::join(behind, "', '"));
      }
    }
    if (const double rate = std::abs(workspace.rows.rate[row]); rate > residual.velocity) {
      residual.velocity = rate;
      residual.velocity_time = t;
      rows.velocity = row;
    }
    const double acceleration =
        std::abs(workspace.rows.E[row] + workspace.solver.along(workspace.rows.L, row, workspace.a));
    if (acceleration > residual.acceleration) {
      residual.acceleration = acceleration;
      residual.acceleration_time = t;
    }
  }
}

void Certifier::observe_projection(double t, const Projection& projection, const Workspace& workspace) {
  for (int g = 0; g < system_.groups; ++g) {
    if (projection.velocity_change[g] <= groups_[g].moved_most) continue;
    groups_[g].moved_most = projection.velocity_change[g];
    groups_[g].moved_time = t;
    groups_[g].moved_row = projection.worst_row[g];
  }
  if (const auto reason = singular_.observe_projection(t, projection, workspace)) distrust(t, *reason);
}

void Certifier::observe_step(const State& state, const Eigen::VectorXd& a, int order, bool joined,
                             const Eigen::VectorXd* within) {
  order_ = order;
  step_watch_.observe(state, a, joined, within);
}

void Certifier::judge_steps() {
  if (order_ == 0) return;
  const StepWatch::Finding worst = step_watch_.worst(order_);
  if (worst.coordinate < 0) return;
  certificate_.step_defect = worst.part;
  certificate_.step_defect_time = worst.time;
  certificate_.step_defect_coordinate = system_.coordinates[worst.coordinate].name;
  if (worst.part > StepWatch::limit) distrust(worst.time, step_watch_.reason(worst));
}

void Certifier::judge_residuals() {
  const double limit = certificate_.energy_threshold;
  for (std::size_t i = 0; i < certificate_.residuals.size(); ++i) {
    const ConstraintResidual& residual = certificate_.residuals[i];
    const ResidualRows& rows = residual_rows_[i];
    const double scale = system_.row_scale[system_.constraints[i].first_row];
    const auto ties = [&](int row) {  // contacts that a method treats itself have no rows
      return fmt::format("{}, between {}", row < 0 ? "" : fmt::format(", row '{}'", system_.row_names[row]),
                         system_.tied_solids(int(i)));
    };
    if (residual.position > limit * scale)
      distrust(residual.position_time,
               fmt::format("constraint '{}' is violated by {:.3g} at t = {:.6g} s (limit {:.2g}){}{}",
                           residual.constraint, residual.position, residual.position_time, limit * scale,
                           ties(rows.position), rows.contradicted));
    if (residual.velocity > limit * scale * groups_[system_.constraints[i].group].largest_speed)
      distrust(
          residual.velocity_time,
          fmt::format("the rate of constraint '{}' has an error of {:.3g} per second at t = {:.6g} s{}",
                      residual.constraint, residual.velocity, residual.velocity_time, ties(rows.velocity)));
  }
}

void Certifier::note_singular_positions() {
  certificate_.singular_passages = singular_.passages();
  certificate_.singular_turn = singular_.largest_turn();
  certificate_.nearness = singular_.nearness();
  certificate_.nearness_time = singular_.nearness_time();
  if (singular_.passages() == 0) return;
  note(
      fmt::format("singular position at t = {:.6g} s, where the rank of the constraint rows falls to {}{}: "
                  "inertia carried the motion through, and its direction turned by at most {:.2g} rad",
                  singular_.first_passage(), singular_.first_rank(),
                  singular_.passages() > 1 ? fmt::format(", and {} more", singular_.passages() - 1) : "",
                  singular_.largest_turn()));
}

void Certifier::note_assembly(const Assembly& assembly) {
  certificate_.assembly_position = assembly.position.size;
  certificate_.assembly_position_coordinate = assembly.position.coordinate;
  certificate_.assembly_velocity = assembly.velocity.size;
  certificate_.assembly_velocity_coordinate = assembly.velocity.coordinate;
  const auto tell = [&](const char* what, const char* per, const Assembly::Move& move) {
    // Smaller moves are rounding in the scene's numbers.
    if (move.relative <= 1e-9) return;
    note(fmt::format(
        "assembly of the constraints changed the initial {}, most of all coordinate '{}', by {:.6g} {}{}",
        what, move.coordinate, move.size, move.angle ? "rad" : "m", per));
  };
  tell("positions", "", assembly.position);
  tell("velocities", "/s", assembly.velocity);
}

void Certifier::observe_overlap(double t, const Contact& contact, double gap) {
  ConstraintResidual& residual = certificate_.residuals[contact.constraint];
  if (-gap <= residual.position) return;
  residual.position = -gap;
  residual.position_time = t;
}

void Certifier::observe_gaps(double t, const Eigen::VectorXd& h) {
  for (const Contact& contact : system_.contacts) observe_overlap(t, contact, h[contact.row]);
}

void Certifier::observe_contacts(double t, const ContactStep& step) {
  for (std::size_t i = 0; i < system_.contacts.size(); ++i) {
    const Contact& contact = system_.contacts[i];
    observe_overlap(t, contact, step.gap[Eigen::Index(i)]);
    double& touching = groups_[system_.constraints[contact.constraint].group].touching;
    touching = std::max(touching, system_.row_scale[contact.row]);
  }
  if (step.passed >= 0)
    distrust(t, fmt::format("bodies at contact '{}' may pass through each other within the step that ends at "
                            "t = {:.6g} s; take shorter steps",
                            system_.contacts[step.passed].name, t));
  if (step.unsettled > ContactStep::most_unsettled)
    distrust(t, fmt::format("the contact impulses did not converge at t = {:.6g} s: {:.2g} of their "
                            "velocities remains, most at '{}'",
                            t, step.unsettled, system_.contacts[step.unsettled_contact].name));
  for (std::size_t i = 0; i < system_.contacts.size(); ++i) {
    const auto contact = Eigen::Index(i);
    // Smaller overlaps are removed, and the energy of that is booked.
    const double limit = certificate_.energy_threshold * system_.row_scale[system_.contacts[i].row],
                 off = std::max(step.bent[contact], goes_through * step.overlap[contact]);
    if (off <= limit) continue;
    distrust(t, fmt::format("the step that ends at t = {:.6g} s is too long for '{}': the error of its gap "
                            "is {:.2g} m (limit {:.2g}); take shorter steps",
                            t, system_.contacts[i].name, off, limit));
  }
  certificate_.impacts += step.impacts;
  certificate_.impact_loss += step.impact_loss;
  for (int g = 0; g < system_.groups; ++g) {
    ContactError& error = groups_[g].contacts;
    error.now += step.group_shift[g] + std::max(0., step.group_work[g] - step.group_shift[g]);
    error.most.observe(t, std::abs(error.now));
  }
}

bool Certifier::too_long(double h, const ContactStep& step, const Eigen::VectorXd& energy,
                         const Work& work) const {
  if (step.passed >= 0 || step.unsettled > ContactStep::most_unsettled) return true;
  const double limit = own_part * certificate_.energy_threshold;
  for (std::size_t i = 0; i < system_.contacts.size(); ++i)
    if (const double length = system_.row_scale[system_.contacts[i].row], part = limit * length;
        std::max(-step.gap[Eigen::Index(i)], step.bent[Eigen::Index(i)]) > part ||
        step.overlap[Eigen::Index(i)] > certificate_.energy_threshold * length)
      return true;
  const double fall =
      // J/kg, free fall over the step: the step's own turnover.
      0.5 * parameters_.gravity.squaredNorm() * h * h;
  for (int g = 0; g < system_.groups; ++g) {
    const EnergyBalance& balance = groups_[g].energy;
    const double allowed =
        std::max(limit * std::max(balance.turnover(), fall * groups_[g].mass), balance.rounding);
    const double done = work.groups[g].total() + step.group_work[g] + step.group_projection[g];
    if (std::abs(balance.changed(energy[g], done)) > allowed || std::abs(step.group_shift[g]) > allowed ||
        step.group_work[g] - step.group_shift[g] > allowed || std::abs(step.group_projection[g]) > allowed)
      return true;
  }
  return false;
}

void Certifier::count_step(double t, double h, bool whole) {
  ++certificate_.steps_accepted;
  step_squares_ += h * h;
  if (!whole && certificate_.smallest_step > 0) return;
  // Fixed steps differ by rounding; the first one is reported.
  if (certificate_.smallest_step > 0 && h >= (1 - 1e-9) * certificate_.smallest_step) return;
  certificate_.smallest_step = h;
  certificate_.smallest_step_time = t;
}

void Certifier::distrust(double t, const std::string& reason) {
  if (!certificate_.reason.empty()) return;
  certificate_.reason = reason;
  certificate_.reason_time = t;
}

Certificate Certifier::finish(const Work& work, long evaluations) {
  Certificate& c = certificate_;
  c.evaluations = evaluations;
  c.work_efforts = work.efforts;
  c.work_drives = work.drives;
  c.work_constraints = work.constraints;
  c.work_baumgarte = work.violation;
  c.work_projection = work.projection;
  c.work_projection_size = work.projection_size;
  note_singular_positions();
  c.work_events = work.events;
  c.work_events_size = work.events_size;
  c.energy_drift = energy_.drift.largest();
  c.energy_drift_time = energy_.drift.time();
  c.energy_turnover = energy_.turnover();
  judge_energy(work);
  const double limit = c.energy_threshold;
  for (int g = 0; g < system_.groups; ++g) {
    const Climb& most = groups_[g].contacts.most;
    const double turnover = energy_scale(g);
    c.contact_error = std::max(c.contact_error, most.largest());
    if (most.largest() > std::max(limit * turnover, groups_[g].energy.rounding))
      distrust(most.time(),
               fmt::format("contact impulses did spurious work on {}, {:.3g} J, which is {:.2g} of the "
                           "{:.3g} J turned over (limit {:.2g}), at t = {:.6g} s; take shorter steps",
                           group_words(g), most.largest(), most.largest() / turnover, turnover, limit,
                           most.time()));
  }
  for (std::size_t i = 0; i < c.conserved.size(); ++i)
    if (const Conserved& conserved = c.conserved[i];
        conserved.drift > std::max(limit * conserved.scale, momenta_[i].rounding))
      distrust(conserved.time,
               fmt::format("the {} has an error of {:.3g} at t = {:.6g} s, {:.2g} of its size (limit {:.2g})",
                           conserved.name, conserved.drift, conserved.time, conserved.drift / conserved.scale,
                           limit));
  judge_residuals();
  judge_steps();
  c.trusted = c.reason.empty();
  return c;
}

}  // namespace borelli
