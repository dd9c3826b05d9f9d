// The contacts of a run: when they close, press no longer, begin or cease to slip, and what happens then.
// Between such moments their modes stay, and closed contacts are constraints like others.
//
// At each of them: contacts that approach meet by the impact law (impact.hpp); of those that then neither
// approach nor part, choose_modes (contact_choice.hpp) says which hold; what is left of their velocities in
// rows that hold (at most the rest speed) is taken away.
#pragma once

#include "dynamics/contacts/contact_choice.hpp"
#include "dynamics/contacts/impact.hpp"
#include "dynamics/run/certifier.hpp"
#include "dynamics/run/event.hpp"

namespace borelli {

// a gap below this part of the length of what touches (System::row_scale) is closed
constexpr double closed_gap = 1e-9;

/// Fails where things overlap at a run's start, with their name and how far; `every`: rows of all contacts.
Result<void> check_apart(const System& system, const ConstraintRows& every);

class ContactEvents : public EventSource {
 public:
  /// `stepping` and `probing`: the workspaces of the run, which are told of the modes.
  ContactEvents(const System& system, const SimulationSettings& settings, Workspace& stepping,
                Workspace& probing, Certifier& certifier);

  /// Sets the modes at a run's start; may change velocities (contacts that close there). Fails where things
  /// overlap, with their name and how far.
  Result<void> start(State& state);
  /// Takes in the state after a step, its equations solved in `workspace`.
  void follow(const Workspace& workspace);

  int count() const override { return functions * int(modes_.size()); }
  Crossing crossing(int) const override { return Crossing::falling; }
  /// Four per contact: its gap while it is open; its normal force while it is closed; the speed of its slip
  /// while it slides, or what is left to the limit of its friction while it sticks; and, at the first of a
  /// constraint's contacts, what is left to the limit of them all together: their forces are not unique, and
  /// one at its limit alone need not slip.
  void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) override;
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override;

  template <class Keeper>
  void keep(Keeper& k) {
    k(w_, modes_, slack_, hit_, cannot_leave_, slip_at_limit_, borne_, shared_, any_closed_, any_slack_);
  }

 private:
  static constexpr int functions = 4;
  /// All rows of all contacts, and the equations' terms without any, at a state.
  Result<void> look(const State& state);
  Result<void> settle(State& state, std::vector<LoggedEvent>& log);
  Result<void> meet(State& state, const std::vector<int>& closed, std::vector<LoggedEvent>& log);
  Result<void> choose(const State& state, const std::vector<int>& closed);
  /// What impulses on the contacts do, with their velocities; and what they do to all velocities: nv x 3n.
  Shock shock_of(const std::vector<int>& contacts, Eigen::MatrixXd& response);
  Result<void> take_away_speed(State& state);
  void log_changes(double t, const std::vector<ContactMode>& before, std::vector<LoggedEvent>& log) const;
  void tell();
  void compare_sums(std::span<EventValue> values);
  double length_of(int i) const { return system_.row_scale[system_.contacts[i].row]; }
  /// m, of what meets.
  double size_of(int i) const;
  double friction_of(int i) const;
  bool has_company(int i) const;
  /// The acceleration that a unit force along a row gives along it, the bilateral constraints apart.
  bool approach(const State& state, const std::vector<int>& contacts) const;
  double mobility(int row);

  const System& system_;
  const SimulationSettings& settings_;
  Workspace &stepping_, &probing_;
  Certifier& certifier_;
  Workspace w_;
  ConstraintRows every_;  ///< the rows of all contacts
  std::vector<ContactMode> modes_;
  std::vector<double> slack_;  ///< m: what a contact that was let go overlaps, and may close by rounding
  std::vector<char> hit_;
  std::vector<char> cannot_leave_;  ///< parts, but so slowly that by rounding it meets again at once
  std::vector<Eigen::Vector2d>
      slip_at_limit_;  ///< of those that come to their limit: where to they slide; zero: none
  std::vector<Eigen::Vector2d>
      borne_;  ///< against what the constraint's contacts bear together, when last looked at
  std::vector<char>
      shared_;  ///< sticks though it came to its own limit: others of its constraint bear what it cannot
  bool any_closed_ = false, any_slack_ = false;
};

}  // namespace borelli
