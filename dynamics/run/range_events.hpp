// Logs coordinates that leave or re-enter their range. The first time of each also goes to the certificate's
// notes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "dynamics/run/certifier.hpp"
#include "dynamics/run/event.hpp"

namespace borelli {

/// One end of the range of a coordinate's component.
struct RangeEnd {
  int coordinate = 0;  ///< in System::ranges
  int component = 0;   ///< of its velocity
  bool upper = false;
};

/// Name of a range end in the event log, and the range end of a name; none if no range end has that name.
std::string range_end_name(const System& system, const RangeEnd& end);
std::optional<RangeEnd> range_end_named(const System& system, std::string_view name);

/// Whether a note of the certificate reports that a range was left.
bool is_range_note(std::string_view note);

class RangeEvents : public EventSource {
 public:
  RangeEvents(const System& system, Certifier& certifier);
  int count() const override { return int(outside_.size()); }
  Crossing crossing(int) const override { return Crossing::both; }
  /// Two functions per range: distance below the upper end and above the lower one, m or rad; both include
  /// the tolerance of Range::holds.
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
