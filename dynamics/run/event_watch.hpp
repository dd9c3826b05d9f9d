// Finds the first event in a step of any length. A function has no zero between two samples in either case:
// both values exceed what its speed allows, or the cubic through values and rates at both stays off zero and
// a sample in the middle confirms the cubic. Otherwise the interval is bisected. A function that starts at
// zero (after an impact) is first followed until it has left zero.
#pragma once

#include <optional>

#include "dynamics/run/event.hpp"
#include "dynamics/run/step_path.hpp"

namespace borelli {

class EventWatch {
 public:
  EventWatch(const System& system, std::vector<EventSource*> sources);

  bool empty() const { return values_.empty(); }
  /// Takes over the functions at the start of the run.
  void start(const State& state, const Kinematics& kinematics);
  /// Begins a step at the end of the last one.
  void begin_step();

  /// Finds the first remaining event in the step from t of length h; `landing` receives its state. Returns
  /// false if none. `end` is the step's end. Located to the resolution of time in double precision. Fails if
  /// the step passes more events than can be resolved.
  Result<bool> find(StepPath& path, double t, double h, const Landing& end, Landing& landing);
  /// Passes the found event to its sources; `workspace` holds the equations there. Returns what the run must
  /// do next.
  Result<AfterEvent> handle(Landing& landing, Workspace& workspace, std::vector<LoggedEvent>& log);

  template <class Keeper>
  void keep(Keeper& k) {
    k(watched_, values_, end_known_, theta_, resolution_);
  }

 private:
  struct Watched {
    Crossing crossing;
    int side;             ///< sign of the function, +1 or -1, where last known
    int side_at_end = 0;  ///< sign at the step's end if no event remains in the step
    double from = 0;      ///< theta from which on it is searched
    double fastest = 0;   ///< rough bound of its rate within the step
    EventValue start, end;
    double found = 2;  ///< theta of its next event in this step; above 1: none
    bool searched = false;
  };
  void evaluate(const State& state, const Kinematics& kinematics);
  void evaluate_at(const State& state);
  /// A sample of one function within the step.
  struct Look {
    double theta = 0;
    EventValue value;
  };
  /// A sample of all functions, kept because their searches begin at the same times.
  struct Kept {
    double theta = 0;
    std::vector<EventValue> values;
  };
  class Search;
  Result<void> search(int i, StepPath& path, double h, Landing& landing);

  const System& system_;
  std::vector<EventSource*> sources_;
  std::vector<int> first_;  ///< index of each source's first function
  std::vector<EventValue> values_;
  std::vector<Watched> watched_;
  std::optional<Kinematics> kinematics_;  ///< empty without functions
  std::vector<int> hits_, which_;
  std::vector<Look> ahead_;  ///< scratch
  std::vector<Kept> kept_;   ///< samples of this step, the first kept_count_ of them
  std::size_t kept_count_ = 0;
  bool end_known_ = false;
  long samples_ = 0;       ///< in this step
  double theta_ = 0;       ///< of the event found
  double resolution_ = 0;  ///< of theta
};

}  // namespace borelli
