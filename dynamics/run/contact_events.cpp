#include "dynamics/run/contact_events.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/equations/branch_sparse.hpp"

namespace borelli {

namespace {

// Relative to the length scale: rounding may close the gap of a released contact by this much.
constexpr double rounding_gap = 1e-10;

// Contacts approach if faster than this fraction of the largest velocity.
constexpr double approaching = 1e-11;

// Rounds of impacts and mode choices at one moment; each may cause the other.
constexpr int most_rounds = 8;

// Friction this close to its limit has not passed it.
constexpr double at_limit_rounding = 1e-9;

}  // namespace

ContactEvents::ContactEvents(const System& system, const SimulationSettings& settings, Workspace& stepping,
                             Workspace& probing, Certifier& certifier)
    : system_(system),
      settings_(settings),
      stepping_(stepping),
      probing_(probing),
      certifier_(certifier),
      w_(system),
      every_(system),
      modes_(system.contacts.size()),
      slack_(system.contacts.size(), 0),
      hit_(system.contacts.size(), false),
      cannot_leave_(hit_),
      slip_at_limit_(system.contacts.size(), Eigen::Vector2d::Zero()),
      borne_(slip_at_limit_),
      shared_(system.contacts.size(), false) {
  every_.every_row = true;
}

double ContactEvents::friction_of(int i) const {
  const Contact& contact = system_.contacts[i];
  return contact.tangents ? surface_of(system_.parameters.constraints[contact.constraint].kind).friction : 0;
}

double ContactEvents::size_of(int i) const {
  const double radii = radii_of(system_.parameters.constraints[system_.contacts[i].constraint].kind);
  return radii > 0 ? radii : length_of(i);
}

void ContactEvents::tell() {
  stepping_.rows.modes = probing_.rows.modes = w_.rows.modes = modes_;
  any_closed_ = any_closed(modes_);
  any_slack_ = std::any_of(slack_.begin(), slack_.end(), [](double slack) { return slack > 0; });
}

Result<void> ContactEvents::find_rows(const State& state) {
  for (ContactMode& mode : w_.rows.modes) mode = {};
  if (const Fault fault =
          update_terms(system_, system_.parameters, state.t, state.q.data(), state.v.data(), w_))
    return tl::unexpected(describe(system_, fault, state.t));
  scan_constraints(system_, system_.parameters, w_.kinematics, every_);
  return {};
}

Result<void> check_apart(const System& system, const ConstraintRows& every) {
  for (const Contact& contact : system.contacts) {
    const double gap = every.h[contact.row];
    if (gap < -closed_gap * system.row_scale[contact.row])
      return failure(
          fmt::format("contact '{}'", contact.name),
          fmt::format("overlaps by {:.6g} at the start; move the bodies apart by that much", -gap));
  }
  return {};
}

Result<void> ContactEvents::start(State& state) {
  if (auto done = find_rows(state); !done) return done;
  if (auto done = check_apart(system_, every_); !done) return done;
  return settle(state, certifier_.events());
}

void ContactEvents::follow(const Workspace& workspace) {
  bool changed = false;
  for (int i : workspace.friction.sliding)
    for (int c = 0; c < 2; ++c) {
      changed = true;
      modes_[i].slip[c] = workspace.rows.slip_along[i][c];
    }
  every_.detail = ConstraintRows::Detail::values;
  scan_constraints(system_, system_.parameters, workspace.kinematics, every_);
  every_.detail = ConstraintRows::Detail::rows;
  certifier_.observe_gaps(workspace.kinematics.t, every_.h);
  if (any_slack_) {
    for (std::size_t i = 0; i < slack_.size(); ++i)
      if (slack_[i] > 0 && every_.h[system_.contacts[i].row] > slack_[i]) {
        slack_[i] = 0;
        changed = true;
      }
  }
  if (changed) tell();
}

void ContactEvents::evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) {
  scan_constraints(system_, system_.parameters, kinematics, every_);
  // If the equations have no solution, there is no force to watch; the step itself reports that.
  const bool solved = any_closed_ && !accelerate(system_, system_.parameters, state.t, state.q.data(),
                                                 state.v.data(), {}, w_);
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const int row = system_.contacts[i].row;
    const ContactMode& mode = modes_[i];
    EventValue* value = &values[functions * i];
    value[0] = value[1] = value[2] = value[3] = {1, 0};
    if (mode.touch == Touch::open) {
      const int rows = system_.contacts[i].tangents ? 3 : 1;
      value[0] = {every_.h[row] + slack_[i], every_.rate[row],
                  std::max(every_.rate.segment(row, rows).norm(), every_.speed[row]), size_of(int(i))};
      continue;
    }
    if (!solved) continue;
    value[1] = {w_.multipliers[row], 0};
    const double friction = friction_of(int(i));
    if (friction == 0) continue;
    if (mode.touch == Touch::sliding)
      // A contact at its full friction that does not slide has a slip of zero only to rounding.
      value[2] = {every_.rate[row + 1] * mode.slip[0] + every_.rate[row + 2] * mode.slip[1] + least_slip, 0};
    else if (!shared_[i])
      value[2] = {(1 + at_limit_rounding) * friction * w_.multipliers[row] -
                      std::hypot(w_.multipliers[row + 1], w_.multipliers[row + 2]),
                  0};
  }
  if (solved) compare_sums(values);
}

/// The margin to the friction limit of each constraint's contacts together.
void ContactEvents::compare_sums(std::span<EventValue> values) {
  for (std::size_t first = 0, i = 0; first < modes_.size(); first = i) {
    const int constraint = system_.contacts[first].constraint;
    double normal = 0;
    Eigen::Vector2d across = Eigen::Vector2d::Zero();
    bool sticks = false;
    for (; i < modes_.size() && system_.contacts[i].constraint == constraint; ++i) {
      if (modes_[i].touch == Touch::open || !system_.contacts[i].tangents) continue;
      const int row = system_.contacts[i].row;
      sticks = sticks || modes_[i].touch == Touch::sticking;
      normal += w_.multipliers[row];
      across += w_.multipliers.segment<2>(row + 1);
    }
    const double size = across.norm();
    for (std::size_t k = first; k < i; ++k)
      borne_[k] = size > 0 ? Eigen::Vector2d(-across / size) : Eigen::Vector2d::Zero();
    if (sticks)
      values[functions * first + 3] = {
          (1 + at_limit_rounding) * friction_of(int(first)) * normal - across.norm(), 0};
  }
}

/// Whether another contact of the same constraint is closed; their forces are then not unique.
bool ContactEvents::has_company(int i) const {
  for (std::size_t k = 0; k < modes_.size(); ++k)
    if (int(k) != i && modes_[k].touch != Touch::open &&
        system_.contacts[k].constraint == system_.contacts[i].constraint)
      return true;
  return false;
}

Result<AfterEvent> ContactEvents::handle(std::span<const int> which, State& state, Workspace&,
                                         std::vector<LoggedEvent>& log) {
  for (int f : which) {
    const int i = f / functions, what = f % functions;
    if (what == 0) hit_[i] = true;
    if (what == 2 && modes_[i].touch == Touch::sticking) {
      if (has_company(i))
        shared_[i] = true;
      else
        slip_at_limit_[i] = borne_[i];
    }
    if (what == 3)
      for (std::size_t k = 0; k < modes_.size(); ++k)
        if (system_.contacts[k].constraint == system_.contacts[i].constraint) slip_at_limit_[k] = borne_[k];
  }
  if (auto done = find_rows(state); !done) return tl::unexpected(done.error());
  if (auto done = settle(state, log); !done) return tl::unexpected(done.error());
  return AfterEvent::restart;
}

/// Handles the event at a state that find_rows() has evaluated.
Result<void> ContactEvents::settle(State& state, std::vector<LoggedEvent>& log) {
  const std::vector<ContactMode> before = modes_;
  std::vector<int> closed;
  for (std::size_t i = 0; i < modes_.size(); ++i)
    cannot_leave_[i] = hit_[i] && every_.rate[system_.contacts[i].row] > 0;
  for (int i = 0; i < int(modes_.size()); ++i) {
    const int row = system_.contacts[i].row;
    const bool touches =
        before[i].touch != Touch::open || hit_[i] || every_.h[row] <= closed_gap * length_of(i);
    if (!touches) continue;
    if (mobility(row) == 0) {  // between driven bodies
      if (every_.rate[row] < -settings_.rest_speed || every_.h[row] < -closed_gap * length_of(i))
        return failure(fmt::format("contact '{}'", system_.contacts[i].name),
                       fmt::format("closes at t = {:.9g} s at {:.3g} per second, and no impulse can stop it, "
                                   "because both bodies are driven",
                                   state.t, -every_.rate[row]));
      continue;
    }
    closed.push_back(i);
  }
  for (int round = 0; round == 0 || approach(state, closed); ++round) {
    if (round == most_rounds)
      return failure(
          fmt::format("contact '{}'", system_.contacts[closed[0]].name),
          fmt::format(
              "this contact and others keep colliding without end at t = {:.9g} s, each time one comes to "
              "rest; give a higher rest_speed, or use the method moreau, which steps over such moments",
              state.t));
    if (round > 0) {
      if (auto done = find_rows(state); !done) return done;
      std::fill(cannot_leave_.begin(), cannot_leave_.end(), false);
    }
    if (approach(state, closed)) {
      if (auto done = meet(state, closed, log); !done) return done;
      if (auto done = find_rows(state); !done) return done;
    }
    if (auto done = choose(state, closed); !done) return done;
    tell();
    if (!any_closed_) break;
    if (auto done = take_away_speed(state); !done) return done;
    // This may press other contacts together.
    for (const int i : closed)
      every_.rate[system_.contacts[i].row] +=
          every_.L.row(system_.contacts[i].row).head(system_.nv).dot(w_.correction);
  }
  tell();
  std::fill(hit_.begin(), hit_.end(), false);
  std::fill(slip_at_limit_.begin(), slip_at_limit_.end(), Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < modes_.size(); ++i)
    if (before[i].touch != Touch::sticking || modes_[i].touch != Touch::sticking) shared_[i] = false;
  log_changes(state.t, before, log);
  return {};
}

/// Whether any of the contacts approaches faster than rounding.
bool ContactEvents::approach(const State& state, const std::vector<int>& contacts) const {
  double speed = 0;
  for (int i = 0; i < system_.nv; ++i) speed = std::max(speed, std::abs(state.v[i]));
  const double least = std::max(approaching * speed, 1e-3 * settings_.rest_speed);
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](int i) { return every_.rate[system_.contacts[i].row] < -least; });
}

double ContactEvents::mobility(int row) {
  if (every_.L.row(row).head(system_.nv).isZero(0)) return 0;  // there may be no coordinates
  w_.correction = every_.L.row(row).head(system_.nv).transpose();
  solve_transposed(system_, w_.factor, w_.correction.data());
  return w_.correction.squaredNorm();
}

Shock ContactEvents::shock_of(const std::vector<int>& contacts, Eigen::MatrixXd& response) {
  const int n = int(contacts.size()), nv = system_.nv;
  Shock shock;
  shock.velocity = Eigen::VectorXd::Zero(3 * n);
  shock.slip.assign(n, Eigen::Vector2d::Zero());
  response = Eigen::MatrixXd::Zero(nv, 3 * n);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3 * n, nv);
  w_.solver.prepare(w_.rows.L, w_.factor, true);
  for (int k = 0; k < n; ++k) {
    const Contact& contact = system_.contacts[contacts[k]];
    shock.surfaces.push_back(surface_of(system_.parameters.constraints[contact.constraint].kind));
    shock.pair.push_back(contact.constraint);
    for (int c = 0; c < (contact.tangents ? 3 : 1); ++c) {
      J.row(3 * k + c) = every_.L.row(contact.row + c).head(nv);
      shock.velocity[3 * k + c] = every_.rate[contact.row + c];
      Eigen::VectorXd x = J.row(3 * k + c).transpose();
      solve_transposed(system_, w_.factor, x.data());
      solve_lower(system_, w_.factor, x.data());
      w_.wanted.noalias() = -w_.rows.L.leftCols(nv) * x;
      w_.solver.correct(w_.factor, w_.wanted, w_.correction);
      response.col(3 * k + c) = x + w_.correction;
    }
  }
  shock.response = J * response;
  return shock;
}

/// The impact of the closed contacts, by the scene's impact law.
Result<void> ContactEvents::meet(State& state, const std::vector<int>& closed,
                                 std::vector<LoggedEvent>& log) {
  Eigen::MatrixXd response;
  const Shock shock = shock_of(closed, response);
  const int n = int(closed.size());
  for (int k = 0; k < n; ++k)
    if (shock.velocity[3 * k] < 0 &&
        !(shock.response(3 * k, 3 * k) > 1e-12 * mobility(system_.contacts[closed[k]].row)))
      return failure(fmt::format("contact '{}'", system_.contacts[closed[k]].name),
                     fmt::format("closes at t = {:.9g} s, and no impulse can stop it, because other "
                                 "constraints keep the bodies from separating",
                                 state.t));
  const ShockResult result = resolve(shock, settings_.impacts, settings_.restitution, settings_.rest_speed);
  if (!result.settled) {
    const bool together =
        settings_.impacts == ImpactLaw::sequential &&
        resolve(shock, ImpactLaw::simultaneous, settings_.restitution, settings_.rest_speed).settled;
    return failure(
        system_.scene,
        fmt::format("impacts follow each other without end at t = {:.9g} s, among them at '{}'{}", state.t,
                    system_.contacts[closed[0]].name,
                    together ? "; impacts = \"simultaneous\" resolves them all at once"
                             : ": the bodies cannot separate; check whether they are driven from two sides"));
  }
  state.v += response * result.impulse;
  for (int k = 0; k < n; ++k) {
    if (result.impulse[3 * k] == 0) continue;
    log.push_back(
        {state.t, "impact", system_.contacts[closed[k]].name, result.impulse[3 * k], result.lost[k]});
    if (result.energetic) log.back().name += " (rebound reduced, so that energy does not rise)";
    certifier_.count_impact(result.lost[k]);
  }
  return {};
}

/// Chooses the modes of closed contacts that separate no faster than the rest speed, or too slowly against
/// rounding; all others open.
Result<void> ContactEvents::choose(const State& state, const std::vector<int>& closed) {
  for (ContactMode& mode : modes_) mode = {};
  std::fill(slack_.begin(), slack_.end(), 0);
  std::vector<int> contacts;
  for (int i : closed) {
    const int row = system_.contacts[i].row;
    slack_[i] = std::max(0., -every_.h[row]);
    if (every_.rate[row] <= settings_.rest_speed || cannot_leave_[i]) contacts.push_back(i);
  }
  if (contacts.empty()) return {};
  for (ContactMode& mode : w_.rows.modes) mode = {};
  if (const Fault fault =
          accelerate(system_, system_.parameters, state.t, state.q.data(), state.v.data(), {}, w_))
    return tl::unexpected(describe(system_, fault, state.t));
  const Eigen::VectorXd free = w_.a;
  Eigen::MatrixXd response;
  Shock shock = shock_of(contacts, response);
  std::vector<Eigen::Vector2d> at_limit;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Contact& contact = system_.contacts[contacts[k]];
    at_limit.push_back(slip_at_limit_[contacts[k]]);
    const Eigen::Vector2d slip = shock.velocity.segment<2>(3 * k + 1);
    if (slip.norm() > settings_.rest_speed) shock.slip[k] = slip.normalized();
    for (int c = 0; c < (contact.tangents ? 3 : 1); ++c)
      shock.velocity[3 * k + c] =
          every_.L.row(contact.row + c).head(system_.nv).dot(free) + every_.E[contact.row + c];
  }
  const Choice choice = choose_modes(shock, at_limit, system_.parameters.gravity.norm());
  if (choice.jammed >= 0)
    return failure(fmt::format("contact '{}'", system_.contacts[contacts[choice.jammed]].name),
                   fmt::format("no contact force solves the equations at t = {:.9g} s (Painleve's paradox): "
                               "without force the contact closes, and while it slides, friction presses it "
                               "together faster than the normal force separates it; lower its friction",
                               state.t));
  if (!choice.settled)
    return failure(
        fmt::format("contact '{}'", system_.contacts[contacts[0]].name),
        fmt::format("its forces and those of the other closed contacts do not converge at t = {:.9g} s",
                    state.t));
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    modes_[contacts[k]] = choice.modes[k];
    double& slack = slack_[contacts[k]];
    slack = choice.modes[k].touch == Touch::open ? slack + rounding_gap * length_of(contacts[k]) : 0;
  }
  return {};
}

/// Sets velocities along active rows to zero, by the least change in the norm of the mass matrix.
Result<void> ContactEvents::take_away_speed(State& state) {
  if (const Fault fault =
          update_terms(system_, system_.parameters, state.t, state.q.data(), state.v.data(), w_))
    return tl::unexpected(describe(system_, fault, state.t));
  w_.solver.prepare(w_.rows.L, w_.factor, true);
  w_.wanted = -w_.rows.rate;
  w_.solver.correct(w_.factor, w_.wanted, w_.correction);
  state.v += w_.correction;
  return {};
}

void ContactEvents::log_changes(double t, const std::vector<ContactMode>& before,
                                std::vector<LoggedEvent>& log) const {
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Touch was = before[i].touch, is = modes_[i].touch;
    const std::string& name = system_.contacts[i].name;
    const bool rubs = friction_of(int(i)) > 0;
    const double *from = before[i].slip, *to = modes_[i].slip;
    const bool turned = was == Touch::sliding && from[0] * to[0] + from[1] * to[1] < 0;
    if (was == is && !turned) continue;
    if (was == Touch::open) log.push_back({t, "contact_closed", name});
    if (is == Touch::open)
      log.push_back({t, "contact_opened", name});
    else if (rubs)
      log.push_back({t, is == Touch::sticking ? "stick" : "slip", name});
  }
}

}  // namespace borelli
