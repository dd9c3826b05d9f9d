// Events are zeros of functions of the state. A run locates them within a step, the earliest first, and
// passes them to their source. The source may change velocities or the mode of the motion (an impact), or
// only record the event.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "dynamics/equations/equations.hpp"

namespace borelli {

/// A function of the state whose zeros are events.
struct EventValue {
  double value = 0;
  double rate = 0;  ///< time derivative along the motion
  /// Upper bound of its rate at this state for any direction of motion (the speed of colliding bodies);
  /// values below |rate| count as |rate|. A function with neither rate nor speed is checked only at the ends
  /// of steps.
  double speed = 0;
  /// The smallest change over which it may turn back: the size of the colliding bodies, through which a long
  /// step may pass unseen.
  double size = std::numeric_limits<double>::infinity();
};

/// The sign changes that count as events.
enum class Crossing { falling, rising, both };

/// What the run does after an event.
enum class AfterEvent {
  go_on,  ///< nothing changed: the step that contains the event stands
  /// Velocities, functions or equations changed: the step ends at the event and the method forgets earlier
  /// steps.
  restart
};

/// Functions to watch for events, and the action at an event. One class per kind of event: impacts,
/// coordinate ranges, a user's own.
class EventSource {
 public:
  virtual ~EventSource() = default;
  /// The number of functions; constant through a run.
  virtual int count() const = 0;
  virtual Crossing crossing(int i) const = 0;
  /// values[i] <- the functions at `state`; `kinematics` holds its kinematics. An inactive function returns
  /// any constant of one sign, e.g. 1. Must not allocate.
  virtual void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) = 0;
  /// The functions `which` are zero at `state`, all at the same time. `workspace` holds the solved equations
  /// there and may be used as scratch. May change state.v within what the constraints allow, and then returns
  /// `restart`. Must not change time or positions. Writes what happened to `log`.
  virtual Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                                    std::vector<LoggedEvent>& log) = 0;
};

}  // namespace borelli
