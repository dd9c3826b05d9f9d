#include "dynamics/system/coupled_switch.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>

namespace borelli {

namespace {

/// A scalar coordinate's start: its value, and its rate.
struct Start {
  double value = 0, rate = 0;
};

class Couplings {
 public:
  explicit Couplings(const Scene& scene) : scene_(scene) {
    for (const Solid& solid : scene.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i)
        if (const std::string name = coordinate_name(solid, i); !name.empty())
          coordinates_[name] = {&solid, &solid.switches[i]};
  }

  Result<Scene> resolve() {
    Scene out = scene_;
    for (std::size_t s = 0; s < scene_.solids.size(); ++s)
      for (std::size_t i = 0; i < scene_.solids[s].switches.size(); ++i) {
        const Switch& one = scene_.solids[s].switches[i];
        const auto* coupled = std::get_if<Coupled>(&one.motion);
        if (!coupled) continue;
        const std::string name = coordinate_name(scene_.solids[s], i);
        const auto start = start_of(name);
        if (!start) return tl::unexpected(start.error());
        Switch& freed = out.solids[s].switches[i];
        freed.motion = Free{};
        freed.q = {start->value};
        freed.v = {start->rate};
        out.constraints.push_back({fmt::format("coupling of '{}'", name),
                                   CoordinateFunction{{name}, {coupled->to}, coupled->function},
                                   scene_.solids[s].line});
      }
    return out;
  }

 private:
  struct Known {
    const Solid* solid;
    const Switch* one;
    std::optional<Start> start = {};  ///< set when first asked for
  };

  /// The start of a known coordinate: follows its couplings to the last one, then evaluates them in reverse.
  /// (A loop, since chains of couplings may be long.)
  Result<Start> start_of(const std::string& name) {
    std::vector<std::string> chain{name};
    while (const Coupled* coupled = coupling_of(chain.back())) {
      if (auto fine = check(chain.back(), *coupled); !fine) return tl::unexpected(fine.error());
      if (chain.size() > coordinates_.size())
        return bad_use(where(chain.back()),
                       fmt::format("is coupled to '{}', which is coupled back to it", coupled->to));
      chain.push_back(coupled->to);
    }
    auto last = own_start(chain.back());
    if (!last) return last;
    Start start = *last;
    for (;; chain.pop_back()) {
      if (const Coupled* coupled = coupling_of(chain.back())) {
        const TimeValue f = at(coupled->function, start.value);
        start = {f.value, f.rate * start.rate};
      }
      coordinates_.at(chain.back()).start = start;
      if (chain.size() == 1) return start;
    }
  }

  /// The coordinate's coupling; null if it has none or its start is known.
  const Coupled* coupling_of(const std::string& name) const {
    const Known& known = coordinates_.at(name);
    return known.start ? nullptr : std::get_if<Coupled>(&known.one->motion);
  }

  std::string where(const std::string& name) const {
    return fmt::format("{}, coordinate '{}'", scene_.where(*coordinates_.at(name).solid), name);
  }

  Result<void> check(const std::string& name, const Coupled& coupled) const {
    const Switch& one = *coordinates_.at(name).one;
    if (auto fine = check_scalar(name, one); !fine) return fine;
    if (!one.q.empty() || !one.v.empty())
      return bad_use(where(name),
                     "is coupled: its position and velocity come from its function; remove q and v");
    if (!coordinates_.contains(coupled.to))
      return bad_use(where(name),
                     fmt::format("is coupled to coordinate '{}', which is not in the scene", coupled.to));
    if (const std::string bad = complaint_of(coupled.function); !bad.empty())
      return bad_use(where(name), bad);
    return {};
  }

  Result<void> check_scalar(const std::string& name, const Switch& one) const {
    if (std::visit([](const auto& kind) { return kind.nq; }, one.kind) == 1) return {};
    return bad_use(where(name), "has three velocities and cannot be coupled; expected a switch with one");
  }

  /// The start of a coordinate that is not coupled, or whose start is known.
  Result<Start> own_start(const std::string& name) const {
    const Known& known = coordinates_.at(name);
    if (known.start) return *known.start;
    const Switch& one = *known.one;
    if (auto fine = check_scalar(name, one); !fine) return tl::unexpected(fine.error());
    if (const auto* driven = std::get_if<Driven>(&one.motion)) {
      if (driven->functions.size() != 1) return Start{};  // refused with all driven switches
      const TimeValue f = at(driven->functions[0], 0);
      return Start{f.value, f.rate};
    }
    const auto first = [](const std::vector<double>& x) { return x.empty() ? 0 : x[0]; };
    return Start{first(one.q), first(one.v)};
  }

  const Scene& scene_;
  std::map<std::string, Known> coordinates_;
};

}  // namespace

Result<Scene> without_coupled_switches(const Scene& scene) { return Couplings(scene).resolve(); }

}  // namespace borelli
