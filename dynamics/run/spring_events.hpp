// Where springs do not go on smoothly: the bounds of limit springs and the half turn of torsion springs, as
// events. A limit spring's force has a kink there, and a stiff one may be touched for so short a time that a
// step sees nothing of it: within a step it therefore acts as at its start, so that the step is smooth and
// its path goes through the bound. A torsion spring's torque turns round. Each step ends where that is
// passed, and the next begins anew.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/run/event.hpp"
#include "dynamics/scene/effort.hpp"

namespace borelli {

/// Whether there may be any.
bool has_spring_events(const Parameters& parameters);

class SpringEvents : public EventSource {
 public:
  /// Sets how the limit springs of `parameters`, which are the run's own, act.
  SpringEvents(const System& system, Parameters& parameters);
  int count() const override { return first_turn() + int(turns_.size()); }
  bool any_turns() const { return !turns_.empty(); }
  Crossing crossing(int) const override { return Crossing::both; }
  void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) override;
  /// Logs "stop_reached", "stop_left", "stop_slack", "stop_taut" or "half_turn".
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override;

  /// Takes a state for that by which the ones to come are told: limit springs act as there, wherever a step
  /// goes until it meets an event, and half turns are told until almost another one.
  void follow(const Kinematics& kinematics);
  /// Whether from that state to one h later a torsion spring may have turned by so much that it cannot be
  /// told.
  bool turned_too_far(const Kinematics& after, double h) const;

  template <class Keeper>
  void keep(Keeper& k) {
    for (Bound& bound : bounds_) k(bound.slack, held(bound));
    for (Turn& turn : turns_) k(turn.from, turn.speed);
  }

 private:
  struct Bound {
    std::size_t effort;
    int component;                               ///< of a ball's rotation vector
    std::array<bool, 2> slack = {false, false};  ///< beyond the upper and the lower one
  };
  /// A torsion spring: the first component of its quaternion, which goes on through half a turn, is watched.
  struct Turn {
    std::size_t effort;
    Quaternion from = identity_quaternion();  ///< of two that are one turn, the next ones are near this one
    double speed = 0;                         ///< then, rad/s
  };
  /// How the run's spring acts there.
  std::array<bool, 2>& held(const Bound& bound) {
    return std::get<LimitSpring>(parameters_.efforts[bound.effort].kind).held[bound.component];
  }
  /// Fills `at_`.
  void look(const Kinematics& kinematics);
  int first_turn() const { return int(4 * bounds_.size()); }
  /// After look().
  EventValue bound_value(int i) const;
  Quaternion turned(const Turn& turn, const Kinematics& kinematics) const;
  /// Of a in b, in a's axes.
  Eigen::Vector3d turn_rate(const Turn& turn, const Kinematics& kinematics) const;

  const System& system_;
  Parameters& parameters_;
  std::vector<Bound> bounds_;  ///< four functions each: of the upper and the lower one; whether they push
  std::vector<std::pair<double, double>> at_;  ///< per bound: where its coordinate or component is, its rate
  std::vector<Turn> turns_;                    ///< one function each
};

}  // namespace borelli
