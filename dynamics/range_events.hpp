// Coordinates that leave their range, and come back, in the event log; the first time of each in the
// certificate's notes.
#pragma once

#include "dynamics/certifier.hpp"
#include "dynamics/event.hpp"

namespace borelli {

class RangeEvents : public EventSource {
 public:
  RangeEvents(const System& system, Certifier& certifier);
  int count() const override { return int(outside_.size()); }
  Crossing crossing(int) const override { return Crossing::both; }
  /// Two per range: how far below the upper end, how far above the lower one; with the room that Range::holds
  /// leaves.
  void evaluate(const State& state, const Kinematics& kinematics, std::span<EventValue> values) override;
  Result<AfterEvent> handle(std::span<const int> which, State& state, Workspace& workspace,
                            std::vector<LoggedEvent>& log) override;

 private:
  struct Watched {
    int coordinate;  ///< in System::ranges
    int component;   ///< of its velocity
  };
  const System& system_;
  Certifier& certifier_;
  std::vector<Watched> watched_;
  std::vector<char> outside_;  ///< per function
  std::vector<char> noted_;    ///< per watched component
};

}  // namespace borelli
