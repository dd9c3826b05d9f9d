// Events: moments at which a function of the state passes zero. A run does not step over them: each is
// located within the step, the earliest first, and handed to whoever watches for it, who may change
// velocities or the mode of the motion (an impact), or only note it.
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
  double rate = 0;  ///< its derivative by time along the motion
  /// How fast it can change at this state, whichever way things turn (the speed of what meets); less than
  /// |rate| counts as |rate|. A function of which neither is known is looked at where steps end.
  double speed = 0;
  /// The least change over which it may turn sharply: the size of what meets, through which a step too long
  /// may pass unseen.
  double size = std::numeric_limits<double>::infinity();
};

/// Which passages through zero count.
enum class Crossing { falling, rising, both };

/// What the run is to do after an event.
enum class AfterEvent {
  go_on,   ///< nothing has changed: the step that passed over the event stands
  restart  ///< velocities, or what the functions or the equations depend on, have changed: the step ends at
           ///< the event, and the method forgets what was before
};

/// Functions that are watched for events, and what is done at them. One class per kind of event: impacts,
/// coordinate ranges, a user's own.
class EventSource {
 public:
  virtual ~EventSource() = default;
  /// How many functions there are; constant through a run.
  virtual int count() const = 0;
  virtual Crossing crossing(int i) const = 0;
  /// values[i] <- the functions at `state`, for which `kinematics` holds. A function that is of no concern at
  /// present has any value that does not change sign, e.g. 1. Must not allocate.
  virtual void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) = 0;
  /// The functions `which` passed zero at `state`, all at the same moment. The equations are solved there in
  /// `workspace` (which may be used as scratch). May change state.v, to what the constraints allow, and
  /// returns `restart` then; may not change time or positions. What happened goes into `log`.
  virtual Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                                    std::vector<LoggedEvent>& log) = 0;
};

}  // namespace borelli
