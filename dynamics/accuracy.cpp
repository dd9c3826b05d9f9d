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

// how often two runs are compared
constexpr int comparisons = 64;

// a tolerance no farther above the least one stays: two runs so near each other tell nothing of their errors
constexpr double worth_lowering = 2;

// a run by another sort of method may cost so many times what has been spent
constexpr double worth_a_try = 5;

void compare(const System& system, const Samples& a, const Samples& b, std::size_t i, Difference& worst) {
  const auto take = [&](double size, std::size_t coordinate) {
    if (size <= worst.size) return;
    worst = {size, a.times[i], int(coordinate)};
  };
  for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
    const CoordinateInfo& info = system.coordinates[c];
    const double unit = system.velocity_scale[info.v_index];
    if (info.q_size == 4) {  // the angle between two orientations, by the chord of their quaternions
      const Quaternion p = a.q[i].segment<4>(info.q_index), q = b.q[i].segment<4>(info.q_index);
      take(4 * std::asin(std::min(1.0, 0.5 * std::min((p - q).norm(), (p + q).norm()))), c);
    } else {
      const double p = a.q[i][info.q_index], q = b.q[i][info.q_index];
      take(std::abs(p - q) / (info.angle ? unit : std::max(unit, std::abs(q))), c);
    }
    for (int k = info.v_index; k < info.v_index + info.v_size; ++k)
      take(std::abs(a.v[i][k] - b.v[i][k]) / (unit + std::abs(b.v[i][k])), c);
  }
}

}  // namespace

Difference largest_difference(const System& system, const Samples& a, const Samples& b) {
  Difference worst;
  for (std::size_t i = 0; i < std::min(a.q.size(), b.q.size()); ++i) compare(system, a, b, i, worst);
  return worst;
}

namespace {

/// The choice of method and tolerance, from run to run.
class Search {
 public:
  Search(const System& system, double start, const SimulationSettings& settings)
      : system_(system), start_(start), settings_(settings), chosen_(settings) {
    chosen_.accuracy = 0;
    // a method of several steps bears no projection between them
    implicit_ =
        system.rows > 0 && settings.constraints == ConstraintTreatment::projection ? "arkode" : "cvode";
    choose_explicit();
  }

  Result<Trajectory> run(const RunOnce& run, const std::function<bool()>& stopped) {
    for (;;) {
      Samples samples;
      samples.times = times();
      auto now = run(chosen_, limits_, samples);
      if (!now || stopped()) return now;
      spent_ += double(now->certificate.evaluations);
      if (samples.q.size() < samples.times.size()) {
        change_method(now->certificate);
        before_.reset();
        continue;
      }
      if (!settings_.verify) {
        tell(now->certificate, std::numeric_limits<double>::quiet_NaN(), "not verified by a finer run");
        return now;
      }
      limits_.evaluations = std::numeric_limits<double>::infinity();  // this method comes through
      if (before_ && judge(largest_difference(system_, *before_, samples), *now)) return now;
      if (!before_) next_tolerance(0.1);
      before_ = std::move(samples);
    }
  }

 private:
  std::vector<double> times() const {
    std::vector<double> out;
    if (!(settings_.end_time > start_)) return out;
    for (int i = 1; i < comparisons; ++i)
      out.push_back(start_ + (settings_.end_time - start_) * i / comparisons);
    out.push_back(settings_.end_time);
    return out;
  }

  void choose_explicit() {
    chosen_.method = settings_.accuracy >= 1e-4 ? "dopri5" : "dop853";
    why_ = settings_.accuracy >= 1e-4 ? "cheapest at such an accuracy" : "cheapest at a high accuracy";
    least_ = least_explicit;
    chosen_.tolerance = std::max(0.1 * settings_.accuracy, 10 * least_);
  }

  /// Gives over to the other sort of method, for five times what has been spent so far.
  void change_method(const Certificate& left) {
    if (found_.empty())
      found_ = fmt::format("{} found the scene stiff at t = {:.6g} s", chosen_.method, left.stiff_from);
    const bool from_implicit = chosen_.method == implicit_;
    if (from_implicit) {
      choose_explicit();
      why_ = fmt::format("{}, but {} needs more than {:.3g} evaluations", found_, implicit_,
                         limits_.evaluations);
    } else {
      chosen_.method = implicit_;
      why_ = found_;
      least_ = least_implicit;
      chosen_.tolerance = std::max(0.1 * settings_.accuracy, 10 * least_);
    }
    limits_ = {.leave_if_stiff = false, .evaluations = worth_a_try * spent_};
  }

  void next_tolerance(double factor) {
    tolerance_before_ = chosen_.tolerance;
    chosen_.tolerance = std::max(chosen_.tolerance * factor, least_);
  }

  void tell(Certificate& c, double error, const std::string& how_known) const {
    c.accuracy = settings_.accuracy;
    c.estimated_error = error;
    c.notes.push_back(fmt::format("accuracy {:.3g}: chose {} ({}) at tolerance {:.2g}; {}",
                                  settings_.accuracy, chosen_.method, why_, chosen_.tolerance, how_known));
  }

  /// Whether the run is the answer; else chooses the next tolerance.
  bool judge(const Difference& found, Trajectory& now) {
    // with errors in proportion to the tolerances, the finer run's is share / (1 - share) of the difference
    const double share = chosen_.tolerance / tolerance_before_;
    const double difference = found.size * std::max(1.0, share / (1 - share));
    const bool reached = difference <= settings_.accuracy;
    if (!reached && chosen_.tolerance > worth_lowering * least_) {
      next_tolerance(std::clamp(0.3 * settings_.accuracy / difference, 1e-3, 0.1));
      return false;
    }
    Certificate& c = now.certificate;
    tell(c, difference,
         fmt::format("differs from the run at {:.2g} by {:.2g}", tolerance_before_, difference));
    if (reached || !c.trusted) return true;
    const CoordinateInfo& worst = system_.coordinates[found.coordinate];
    c.trusted = false;
    c.reason = fmt::format(
        "the accuracy of {:.3g} could not be shown: runs at tolerances {:.2g} and {:.2g} differ by {:.2g} in "
        "coordinate '{}' of '{}' at t = {:.6g} s; shorten the run, or ask for less",
        settings_.accuracy, tolerance_before_, chosen_.tolerance, difference, worst.name, worst.solid,
        found.time);
    c.reason_time = found.time;
    return true;
  }

  const System& system_;
  double start_;
  const SimulationSettings& settings_;
  SimulationSettings chosen_;
  const char* implicit_;
  RunLimits limits_{.leave_if_stiff = true};
  std::string why_, found_;
  double least_ = 0, tolerance_before_ = 0;
  double spent_ = 0;  ///< evaluations, so far
  std::optional<Samples> before_;
};

}  // namespace

Result<Trajectory> run_to_accuracy(const System& system, double start, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped) {
  return Search(system, start, settings).run(run, stopped);
}

}  // namespace borelli
