// Contacts as events of a run: when they close, open, start or stop sliding, and what follows. Between events
// their modes are constant, and closed contacts are constraints like others.
//
// At an event, approaching contacts collide by the impact law (impact.hpp). For contacts that then neither
// approach nor separate, choose_modes (contact_choice.hpp) decides which stay closed. Their remaining
// velocities along closed rows (at most the rest speed) are set to zero.
#pragma once

#include "dynamics/contacts/contact_choice.hpp"
#include "dynamics/contacts/impact.hpp"
#include "dynamics/run/certifier.hpp"
#include "dynamics/run/event.hpp"

namespace borelli {

// A contact is closed if its gap is below this fraction of the length scale of the bodies
// (System::row_scale).
constexpr double closed_gap = 1e-9;

/// Fails if bodies overlap at the start of a run; the message names the contact and the depth. `every`: rows
/// of all contacts.
Result<void> check_apart(const System& system, const ConstraintRows& every);

class ContactEvents : public EventSource {
 public:
  /// `stepping` and `probing`: the workspaces of the run; they receive the contact modes.
  ContactEvents(const System& system, const SimulationSettings& settings, Workspace& stepping,
                Workspace& probing, Certifier& certifier);

  /// Sets the modes at the start of a run; may change velocities if contacts close there. Fails if bodies
  /// overlap; the message names the contact and the depth.
  Result<void> start(State& state);
  /// Takes over the state after a step; its equations are solved in `workspace`.
  void follow(const Workspace& workspace);

  int count() const override { return functions * int(modes_.size()); }
  Crossing crossing(int) const override { return Crossing::falling; }
  /// Four functions per contact. An open contact: its gap. A closed one: its normal force. A sliding one: its
  /// sliding speed; a sticking one: the margin to its friction limit. At the first contact of a constraint:
  /// the margin to the friction limit of all its contacts together, because their forces are not unique and a
  /// single contact at its limit need not slide.
  void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) override;
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override;

  template <class Keeper>
  void keep(Keeper& k) {
    k(w_, modes_, slack_, hit_, cannot_leave_, slip_at_limit_, borne_, shared_, any_closed_, any_slack_);
  }

 private:
  static constexpr int functions = 4;
  /// Finds the rows of all contacts at a state, and the equations' terms without contacts.
  Result<void> find_rows(const State& state);
  Result<void> settle(State& state, std::vector<LoggedEvent>& log);
  Result<void> meet(State& state, const std::vector<int>& closed, std::vector<LoggedEvent>& log);
  Result<void> choose(const State& state, const std::vector<int>& closed);
  /// Velocities of the contacts and their response to impulses; `response`: the change of all velocities per
  /// unit impulse, nv x 3n.
  Shock shock_of(const std::vector<int>& contacts, Eigen::MatrixXd& response);
  Result<void> take_away_speed(State& state);
  void log_changes(double t, const std::vector<ContactMode>& before, std::vector<LoggedEvent>& log) const;
  void tell();
  void compare_sums(std::span<EventValue> values);
  double length_of(int i) const { return system_.row_scale[system_.contacts[i].row]; }
  /// m, length of the colliding bodies: sum of the radii, or the length scale.
  double size_of(int i) const;
  double friction_of(int i) const;
  bool has_company(int i) const;
  /// Whether any of these contacts approaches faster than rounding.
  bool approach(const State& state, const std::vector<int>& contacts) const;
  /// The acceleration along a row by a unit force along it, without the bilateral constraints.
  double mobility(int row);

  const System& system_;
  const SimulationSettings& settings_;
  Workspace &stepping_, &probing_;
  Certifier& certifier_;
  Workspace w_;
  ConstraintRows every_;  ///< the rows of all contacts
  std::vector<ContactMode> modes_;
  /// m, overlap of a released contact, within which rounding must not close it again.
  std::vector<double> slack_;
  std::vector<char> hit_;
  /// Separates too slowly: rounding would make it collide again at once.
  std::vector<char> cannot_leave_;
  /// Per contact: sliding direction when it reaches its friction limit; zero: not at the limit.
  std::vector<Eigen::Vector2d> slip_at_limit_;
  /// Per contact: direction against the total friction of its constraint's contacts, from the last
  /// evaluation.
  std::vector<Eigen::Vector2d> borne_;
  /// Per contact: it sticks although at its own limit, because other contacts of its constraint take the
  /// rest.
  std::vector<char> shared_;
  bool any_closed_ = false, any_slack_ = false;
};

}  // namespace borelli
