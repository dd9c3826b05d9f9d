#include "dynamics/coupled_switch.hpp"

#include <fmt/format.h>

#include <map>

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
        const auto start = start_of(name, 0);
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
  };

  /// Of a coordinate that is there, through those that it is coupled to.
  Result<Start> start_of(const std::string& name, std::size_t depth) const {
    const auto [solid, one] = coordinates_.at(name);
    const std::string where = fmt::format("{}, coordinate '{}'", scene_.where(*solid), name);
    const auto first = [](const std::vector<double>& x) { return x.empty() ? 0 : x[0]; };
    if (std::visit([](const auto& kind) { return kind.nq; }, one->kind) != 1)
      return bad_use(where, "is a ball, which cannot be coupled: expected a switch with one coordinate");
    if (const auto* driven = std::get_if<Driven>(&one->motion)) {
      if (driven->functions.size() != 1) return Start{};  // refused with all driven switches
      const TimeValue f = at(driven->functions[0], 0);
      return Start{f.value, f.rate};
    }
    const auto* coupled = std::get_if<Coupled>(&one->motion);
    if (!coupled) return Start{first(one->q), first(one->v)};
    if (!one->q.empty() || !one->v.empty())
      return bad_use(where, "is coupled: its position and velocity come from its function; remove q and v");
    if (!coordinates_.contains(coupled->to))
      return bad_use(where,
                     fmt::format("is coupled to coordinate '{}', which is not in the scene", coupled->to));
    if (depth > coordinates_.size())
      return bad_use(where, fmt::format("is coupled to '{}', which is coupled back to it", coupled->to));
    if (const std::string bad = complaint_of(coupled->function); !bad.empty()) return bad_use(where, bad);
    const auto other = start_of(coupled->to, depth + 1);
    if (!other) return other;
    const TimeValue f = at(coupled->function, other->value);
    return Start{f.value, f.rate * other->rate};
  }

  const Scene& scene_;
  std::map<std::string, Known> coordinates_;
};

}  // namespace

Result<Scene> without_coupled_switches(const Scene& scene) { return Couplings(scene).resolve(); }

}  // namespace borelli
