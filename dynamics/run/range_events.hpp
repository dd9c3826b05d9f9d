// Coordinates that leave their range, and come back, in the event log; the first time of each in the
// certificate's notes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "dynamics/run/certifier.hpp"
#include "dynamics/run/event.hpp"

namespace borelli {

/// An end of the range of a coordinate's component.
struct RangeEnd {
  int coordinate = 0;  ///< in System::ranges
  int component = 0;   ///< of its velocity
  bool upper = false;
};

/// What the event log calls it when a coordinate crosses that end of its range, and the end of that name.
std::string range_end_name(const System& system, const RangeEnd& end);
std::optional<RangeEnd> range_end_named(const System& system, std::string_view name);

/// Whether a certificate's note tells of a range that was left.
bool is_range_note(std::string_view note);

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

  template <class Keeper>
  void keep(Keeper& k) {
    k(outside_, noted_);
  }

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
