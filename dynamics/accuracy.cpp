#include "dynamics/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "dynamics/pose.hpp"

namespace borelli {

namespace {

// below these rounding is as large as what the methods leave
constexpr double least_explicit = 1e-14, least_implicit = 1e-12;

double row_difference(const System& system, const Trajectory& a, Eigen::Index i, const Trajectory& b,
                      Eigen::Index j) {
  double worst = 0;
  for (const CoordinateInfo& info : system.coordinates) {
    const double unit = system.velocity_scale[info.v_index];
    if (info.q_size == 4) {  // the angle between two orientations, by the chord of their quaternions
      const Quaternion p = a.q.row(i).segment<4>(info.q_index), q = b.q.row(j).segment<4>(info.q_index);
      worst = std::max(worst, 4 * std::asin(std::min(1.0, 0.5 * std::min((p - q).norm(), (p + q).norm()))));
    } else {
      const double p = a.q(i, info.q_index), q = b.q(j, info.q_index);
      worst = std::max(worst, std::abs(p - q) / (info.angle ? unit : std::max(unit, std::abs(q))));
    }
    for (int k = info.v_index; k < info.v_index + info.v_size; ++k)
      worst = std::max(worst, std::abs(a.v(i, k) - b.v(j, k)) / (unit + std::abs(b.v(j, k))));
  }
  return worst;
}

}  // namespace

double largest_difference(const System& system, const Trajectory& a, const Trajectory& b) {
  if (a.times != b.times) return row_difference(system, a, a.q.rows() - 1, b, b.q.rows() - 1);
  double worst = 0;
  for (Eigen::Index i = 0; i < a.q.rows(); ++i) worst = std::max(worst, row_difference(system, a, i, b, i));
  return worst;
}

Result<Trajectory> run_to_accuracy(const System& system, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped) {
  SimulationSettings chosen = settings;
  chosen.accuracy = 0;
  chosen.method = settings.accuracy >= 1e-4 ? "dopri5" : "dop853";
  chosen.tolerance = std::max(0.1 * settings.accuracy, 10 * least_explicit);
  std::string why =
      settings.accuracy >= 1e-4 ? "cheapest at such an accuracy" : "cheapest at a high accuracy";
  // a method of several steps bears no projection between them
  const char* const implicit =
      system.rows > 0 && settings.constraints == ConstraintTreatment::projection ? "arkode" : "cvode";
  bool stiff = false;
  std::optional<Trajectory> before;
  double tolerance_before = 0;
  for (;;) {
    auto now = run(chosen, !stiff);
    if (!now) return now;
    Certificate& c = now->certificate;
    if (stopped()) return now;
    if (!stiff && std::isfinite(c.stiff_from)) {
      stiff = true;
      why = fmt::format("{} found the scene stiff at t = {:.6g} s", chosen.method, c.stiff_from);
      chosen.method = implicit;
      chosen.tolerance = std::max(0.1 * settings.accuracy, 10 * least_implicit);
      before.reset();
      continue;
    }
    const double least = stiff ? least_implicit : least_explicit;
    if (!before) {
      tolerance_before = chosen.tolerance;
      chosen.tolerance *= 0.1;
    } else {
      // with errors in proportion to the tolerances, the finer run's is share / (1 - share) of the difference
      const double share = chosen.tolerance / tolerance_before;
      const double difference =
          largest_difference(system, *before, *now) * std::max(1.0, share / (1 - share));
      const bool reached = difference <= settings.accuracy;
      if (reached || chosen.tolerance <= least) {
        c.accuracy = settings.accuracy;
        c.estimated_error = difference;
        c.notes.push_back(fmt::format(
            "accuracy {:.3g}: chose {} ({}) at tolerance {:.2g}; differs from the run at {:.2g} by {:.2g}",
            settings.accuracy, chosen.method, why, chosen.tolerance, tolerance_before, difference));
        if (!reached && c.trusted) {
          c.trusted = false;
          c.reason = fmt::format(
              "the accuracy of {:.3g} could not be shown: runs at tolerances {:.2g} and {:.2g} differ by "
              "{:.2g}; "
              "shorten the run, or ask for less",
              settings.accuracy, tolerance_before, chosen.tolerance, difference);
          c.reason_time = now->times.back();
        }
        return now;
      }
      tolerance_before = chosen.tolerance;
      chosen.tolerance *= std::clamp(0.3 * settings.accuracy / difference, 1e-3, 0.1);
    }
    chosen.tolerance = std::max(chosen.tolerance, least);
    before = std::move(*now);
  }
}

}  // namespace borelli
