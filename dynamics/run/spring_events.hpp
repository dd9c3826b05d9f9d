// Events of springs: the bounds of limit springs and the half turn of torsion springs. A limit spring's force
// has a kink at its bound, and contact with a stiff one may be too short for a step to see. Within a step the
// spring therefore acts as at the step's start: the step is smooth and its path crosses the bound. A torsion
// spring's torque reverses at the half turn. Each step ends at such an event, and the next one starts afresh.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/run/event.hpp"
#include "dynamics/scene/effort.hpp"

namespace borelli {

/// Whether the efforts include limit or torsion springs.
bool has_spring_events(const Parameters& parameters);

class SpringEvents : public EventSource {
 public:
  /// `parameters` belongs to the run; the constructor and follow() set how its limit springs act.
  SpringEvents(const System& system, Parameters& parameters);
  int count() const override { return first_turn() + int(turns_.size()); }
  bool any_turns() const { return !turns_.empty(); }
  Crossing crossing(int) const override { return Crossing::both; }
  void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) override;
  /// Logs "stop_reached", "stop_left", "stop_slack", "stop_taut" or "half_turn".
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override;

  /// Takes the state at which a step starts as reference. Limit springs act as in this state until the step
  /// meets an event; turns of torsion springs are counted from it, up to almost a full turn.
  void follow(const Kinematics& kinematics);
  /// Whether a torsion spring may have turned ambiguously far from the reference state to `after`, h later
  /// (s).
  bool turned_too_far(const Kinematics& after, double h) const;

  template <class Keeper>
  void keep(Keeper& k) {
    for (Bound& bound : bounds_) k(bound.slack, acting(bound));
    for (Turn& turn : turns_) k(turn.from, turn.speed);
  }

 private:
  struct Bound {
    std::size_t effort;
    int component;  ///< component of a ball's rotation vector
    /// Beyond the upper and the lower bound: the spring is slack (damping cancels its push).
    std::array<bool, 2> slack = {false, false};
  };
  /// A torsion spring. The watched function is the scalar part of its quaternion, which changes sign at half
  /// a turn.
  struct Turn {
    std::size_t effort;
    /// Reference turn: of the two quaternions of a turn, the nearer to this one is used.
    Quaternion from = identity_quaternion();
    double speed = 0;  ///< rad/s, at the reference state
  };
  /// The run's flags whether the limit spring acts beyond the upper and the lower bound.
  std::array<bool, 2>& acting(const Bound& bound) {
    return std::get<LimitSpring>(parameters_.efforts[bound.effort].kind).held[bound.component];
  }
  /// Fills `at_`: coordinate and rate per bound.
  void measure_bounds(const Kinematics& kinematics);
  int first_turn() const { return int(4 * bounds_.size()); }
  /// Call after measure_bounds().
  EventValue bound_value(int i) const;
  Quaternion turned(const Turn& turn, const Kinematics& kinematics) const;
  /// Angular velocity of a relative to b, in a's axes, rad/s.
  Eigen::Vector3d turn_rate(const Turn& turn, const Kinematics& kinematics) const;

  const System& system_;
  Parameters& parameters_;
  std::vector<Bound> bounds_;  ///< four functions per bound: upper, lower; then whether each pushes
  /// Per bound: its coordinate or component, m or rad, and the rate.
  std::vector<std::pair<double, double>> at_;
  std::vector<Turn> turns_;  ///< one function per torsion spring
};

}  // namespace borelli
