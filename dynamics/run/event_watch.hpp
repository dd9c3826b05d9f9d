// Finds the first event in a step, however long that is. Between two looks a function has not been through
// zero if both values are larger than what its speed allows, or if the cubic through values and rates at
// both, which a look in the middle bears out, keeps off zero; else the middle is looked at, and both halves
// in turn. A function that starts at zero (an impact just passed) is first followed to where it has left.
#pragma once

#include <optional>

#include "dynamics/run/event.hpp"
#include "dynamics/run/step_path.hpp"

namespace borelli {

class EventWatch {
 public:
  EventWatch(const System& system, std::vector<EventSource*> sources);

  bool empty() const { return values_.empty(); }
  /// Takes in the functions at the run's start.
  void start(const State& state, const Kinematics& kinematics);
  /// A step begins where the last one ended.
  void begin_step();

  /// The first event that is left in the step from t of length h, with its theta and state in `landing`;
  /// false: none. `end` is the step's end. Located to the resolution of time in double precision. Fails where
  /// the step passes events more often than can be told apart.
  Result<bool> find(StepPath& path, double t, double h, const Landing& end, Landing& landing);
  /// Hands the event found to its sources; `workspace` holds the equations there. Tells what is to be done.
  Result<AfterEvent> handle(Landing& landing, Workspace& workspace, std::vector<LoggedEvent>& log);

  template <class Keeper>
  void keep(Keeper& k) {
    k(watched_, values_, end_known_, theta_, resolution_);
  }

 private:
  struct Watched {
    Crossing crossing;
    int side;             ///< of zero, +1 or -1: where the function was last known to be
    int side_at_end = 0;  ///< the same when no event is left in the step
    double from = 0;      ///< theta from which on it is looked at
    double fastest = 0;   ///< how fast it changes within the step, roughly
    EventValue start, end;
    double found = 2;  ///< theta of its next event in this step; above 1: none
    bool searched = false;
  };
  void evaluate(const State& state, const Kinematics& kinematics);
  void evaluate_at(const State& state);
  /// A look at one function within the step.
  struct Look {
    double theta = 0;
    EventValue value;
  };
  /// Of all functions, kept for the others: their searches begin at the same places.
  struct Kept {
    double theta = 0;
    std::vector<EventValue> values;
  };
  class Search;
  Result<void> search(int i, StepPath& path, double h, Landing& landing);

  const System& system_;
  std::vector<EventSource*> sources_;
  std::vector<int> first_;  ///< of each source's functions
  std::vector<EventValue> values_;
  std::vector<Watched> watched_;
  std::optional<Kinematics> kinematics_;  ///< none where there are no functions
  std::vector<int> hits_, which_;
  std::vector<Look> ahead_;  ///< scratch
  std::vector<Kept> kept_;   ///< of this step, the first kept_count_
  std::size_t kept_count_ = 0;
  bool end_known_ = false;
  long looks_ = 0;         ///< in this step
  double theta_ = 0;       ///< of the event found
  double resolution_ = 0;  ///< of theta
};

}  // namespace borelli
