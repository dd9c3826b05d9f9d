#include "dynamics/run/change_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/run/settings_check.hpp"

namespace borelli {

namespace {

// Steps may exceed the bound by rounding.
constexpr double rounding_slack = 1 + 1e-9;

}  // namespace

ChangeWatch::ChangeWatch(const System& system, const Parameters& parameters, double span, bool tables) {
  if (const auto change = fastest_change(system, parameters, span, tables)) {
    change_ = *change;
    longest_ = longest_step_in_periods * change->period;
  }
}

double ChangeWatch::bounded(double step, double share) {
  if (!(step > share * longest_)) return step;
  limited_ = true;
  return share * longest_;
}

void ChangeWatch::take_step(double from, double made) {
  if (longest_made_ <= rounding_slack * longest_ && made > rounding_slack * longest_) first_overlong_ = from;
  longest_made_ = std::max(longest_made_, made);
}

void ChangeWatch::judge(Certifier& certifier) const {
  if (limited_)
    certifier.note(fmt::format("steps were limited to {:.4g} s, an eighth of the {} of {}", longest_,
                               change_.wave, change_.name));
  if (longest_made_ > rounding_slack * longest_)
    certifier.distrust(
        first_overlong_,
        fmt::format("steps of {:.4g} s (from t = {:.6g} s on) cannot follow {}, whose {} is {:.4g} s; take "
                    "steps of at most {:.4g} s, an eighth of it",
                    longest_made_, first_overlong_, change_.name, change_.wave, change_.period, longest_));
}

}  // namespace borelli
