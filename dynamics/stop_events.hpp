// The bounds of limit springs as events: the force has a kink there, and a stiff spring may be touched for so
// short a time that a step sees nothing of it. Each step ends where a bound is passed, and the next begins
// anew.
#pragma once

#include "dynamics/event.hpp"

namespace borelli {

class StopEvents : public EventSource {
 public:
  StopEvents(const System& system, const Parameters& parameters);
  int count() const override { return int(2 * watched_.size()); }
  Crossing crossing(int) const override { return Crossing::both; }
  void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) override;
  /// Logs "stop_reached" or "stop_left".
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override;

 private:
  struct Watched {
    std::size_t effort;
    int component;  ///< of a ball's rotation vector
  };
  /// Of the coordinate, or of the component: where it is, and its rate.
  std::pair<double, double> at(const Watched& watched, const Kinematics& kinematics) const;
  EventValue value(int i, const Kinematics& kinematics) const;

  const System& system_;
  const Parameters& parameters_;
  std::vector<Watched> watched_;  ///< two functions each: upper bound, lower bound
};

}  // namespace borelli
