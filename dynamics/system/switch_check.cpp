#include "dynamics/system/switch_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

Result<void> check_finite(const std::vector<double>& numbers, const std::string& where) {
  for (double x : numbers)
    if (!std::isfinite(x)) return bad_use(where, "contains a number that is not finite");
  return {};
}

/// Finds a number of a switch's kind that is not finite.
struct NotFinite {
  std::string found;
  void operator()(std::string_view field, double x) {
    if (!std::isfinite(x)) found = field;
  }
  template <class T>
  void operator()(std::string_view, const T&) {}
};

Result<void> make_unit(Eigen::Vector3d& axis, const std::string& where) {
  const double length = axis.norm();
  if (!std::isfinite(length) || length < 1e-12)
    return bad_use(where, fmt::format("its axis ({}, {}, {}) has no direction", axis[0], axis[1], axis[2]));
  axis /= length;
  return {};
}

/// Normalises the axes and checks the numbers.
Result<void> normalise(SwitchKind& kind, const std::string& where) {
  return std::visit(
      [&](auto& k) -> Result<void> {
        if constexpr (requires { k.axis; })
          if (auto done = make_unit(k.axis, where); !done) return done;
        if constexpr (requires { k.parts; })
          for (auto& part : k.parts)
            if (auto done = make_unit(part.axis, where); !done) return done;
        if constexpr (requires { k.complaint(); })
          if (const std::string bad = k.complaint(); !bad.empty()) return bad_use(where, bad);
        NotFinite numbers;
        k.fields(k, numbers);
        if (!numbers.found.empty())
          return bad_use(where, fmt::format("its {} is not a finite number", numbers.found));
        if constexpr (requires { k.X_AB; }) {
          if (!is_rigid(k.X_AB)) return bad_use(where, "its pose is not a rotation and a finite position");
        }
        return {};
      },
      kind);
}

Result<std::vector<double>> initial_position(const Switch& one, int nq, const std::string& where) {
  std::vector<double> q = one.q;
  if (q.empty()) {
    q.assign(nq, 0);
    if (nq == 4) q[0] = 1;
  }
  if (int(q.size()) != nq)
    return bad_use(where, fmt::format("its initial q has {} numbers; expected {}{}", q.size(), nq,
                                      nq == 4 ? " (a quaternion w, x, y, z)" : ""));
  if (auto done = check_finite(q, where + ", initial q"); !done) return tl::unexpected(done.error());
  if (nq == 4) {
    const double norm = Eigen::Map<Quaternion>(q.data()).norm();
    if (std::abs(norm - 1) > 1e-3)
      return bad_use(where, fmt::format("its initial quaternion has length {:.6g}; expected 1", norm));
    for (double& x : q) x /= norm;
  }
  return q;
}

Result<void> check_drive(const Driven& driven, const Switch& one, int nq, int nv, const std::string& where) {
  if (int(driven.functions.size()) != nv)
    return bad_use(
        where, fmt::format("is driven by {} functions of time; expected {}", driven.functions.size(), nv));
  for (const TimeFunction& f : driven.functions)
    if (const std::string bad = complaint_of(f); !bad.empty()) return bad_use(where, bad);
  if (!one.v.empty() || (nq == 1 && !one.q.empty()))
    return bad_use(where,
                   "is driven: its position and velocity come from its function of time; remove q and v");
  return {};
}

}  // namespace

Result<void> check_ranges(const Switch& one, const std::vector<double>& q, const std::string& where) {
  if (one.ranges.empty()) return {};
  const auto [nv, unit] =
      std::visit([](const auto& k) { return std::pair(k.nv, k.rotates ? "rad" : "m"); }, one.kind);
  if (int(one.ranges.size()) != nv)
    return bad_use(where, fmt::format("has {} ranges; expected {}", one.ranges.size(),
                                      nv == 1 ? "one" : "three, one per component of its rotation vector"));
  if (std::holds_alternative<Driven>(one.motion))
    return bad_use(where, "is driven by time, so a range has no effect; remove it");
  for (int i = 0; i < nv; ++i) {
    const Range& range = one.ranges[i];
    const std::string axis = nv == 1 ? "" : fmt::format(" about its {} axis", "xyz"[i]);
    if (!std::isfinite(range.lower) || !std::isfinite(range.upper) || range.lower > range.upper)
      return bad_use(where, fmt::format("its range{} runs from {} to {}; expected two finite numbers, the "
                                        "smaller one first",
                                        axis, range.lower, range.upper));
    if (const double start = ranged_value(q.data(), int(q.size()), i); !range.holds(start))
      return bad_use(where, fmt::format("starts at {}{}, outside its range of {} to {} ({})", start, axis,
                                        range.lower, range.upper, unit));
  }
  return {};
}

Result<CheckedSwitch> check_switch(const Switch& one, const std::string& where) {
  CheckedSwitch out{.kind = one.kind, .kind_name = {}, .q = {}, .v = {}};
  if (auto done = normalise(out.kind, where); !done) return tl::unexpected(done.error());
  std::visit(
      [&](const auto& k) {
        out.nq = k.nq, out.nv = k.nv, out.kind_name = std::string(k.kind);
        out.rotates = k.rotates, out.slides = k.slides;
      },
      out.kind);
  if (out.nv == 0) {
    if (!one.coordinate.empty() || !one.q.empty() || !one.v.empty() || !one.ranges.empty() ||
        one.armature != 0 || one.motion.index() != 0)
      return bad_use(
          where,
          fmt::format("a {} switch has no coordinate: remove its name, q, v, motion, range and armature",
                      out.kind_name));
    return out;
  }
  auto q = initial_position(one, out.nq, where);
  if (!q) return tl::unexpected(q.error());
  out.q = std::move(*q);
  if (!one.v.empty() && int(one.v.size()) != out.nv)
    return bad_use(where, fmt::format("its initial v has {} numbers; a {} needs {}", one.v.size(),
                                      out.kind_name, out.nv));
  if (auto done = check_finite(one.v, where + ", initial v"); !done) return tl::unexpected(done.error());
  out.v = one.v.empty() ? std::vector<double>(out.nv, 0) : one.v;
  if (auto done = check_ranges(one, out.q, where); !done) return tl::unexpected(done.error());
  if (!(one.armature >= 0) || !std::isfinite(one.armature))
    return bad_use(where, fmt::format("its armature is {}; expected 0 or more", one.armature));
  if (const auto* driven = std::get_if<Driven>(&one.motion))
    if (auto done = check_drive(*driven, one, out.nq, out.nv, where); !done)
      return tl::unexpected(done.error());
  if (std::holds_alternative<Locked>(one.motion) &&
      std::any_of(out.v.begin(), out.v.end(), [](double x) { return x != 0; }))
    return bad_use(where, "is locked but starts with a velocity; remove v, or free the coordinate");
  return out;
}

}  // namespace borelli
