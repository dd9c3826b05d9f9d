#include "dynamics/run/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/run/certifier.hpp"

namespace borelli {

namespace {

// Below these tolerances rounding is as large as the error of the methods.
constexpr double least_explicit = 1e-14, least_implicit = 1e-12;

// Number of times at which two runs are compared.
constexpr int comparisons = 64;

// The tolerance is not lowered if it is within this factor of the least one: runs so close tell nothing about
// their errors.
constexpr double worth_lowering = 2;

// Without `verify`. to_do: first tolerance to try for the answer, relative to the accuracy. loosest: its
// upper bound (the certificate distrusts the energy of looser runs). pilot, coarsest: ratio of the pilot
// run's tolerance to it, and its upper bound. apart: difference at which two runs have nothing in common.
// after_apart: factor to the next tolerance then. Tuned on half of the scenes of auto_bench. A loosest of
// 3e-5 would save an eighth on smooth scenes at accuracies 1e-1 and 1e-2, but cost a third more on pendulums
// of 4 to 7 bars.
constexpr double to_do = 0.003, loosest = 3e-6, pilot = 1e5, coarsest = 3e-3, apart = 0.5, after_apart = 0.01;

// Two runs also have nothing in common if they differ by this fraction of the range of motion, however small
// that is on the scale.
constexpr double apart_in_range = 0.25;

// With stops or contacts, errors depend on tolerances by the square root. If two runs farther apart than this
// do not suffice, the third tolerance is close to the second.
constexpr double near_pilot = 1000;

// The first run's velocities are disturbed by this multiple of its tolerance. The difference to the next run
// then shows how the motion amplifies small errors, such as near an unstable position, where steps too long
// for the motion pass any tolerance. An implicit method damps disturbances below its tolerance there, so its
// factor is larger.
constexpr double off_explicit = 0.03, off_implicit = 3;

// After two runs with nothing in common, errors are not proportional to tolerances either: they count with at
// least this multiple of the tolerance ratio's square root.
constexpr double after_parting = 1. / 3;

// An explicit run after an implicit one may cost this multiple of the evaluations so far.
constexpr double worth_a_try = 5;

// The explicit method takes over if the implicit method's first run loses this fraction of the energy
// turnover, and the explicit one would take at most this multiple of its evaluations.
constexpr double much_lost = 0.1, much_cheaper = 3;

// Functions of time may cut a run's steps whatever the tolerance. If they cut more than `mostly_cut` of them,
// the difference to a run at another tolerance does not show the error. Further runs then have a tenth of the
// tolerance, and steps that are `shorter` times as long. A method of order 4 or more keeps at most
// `shorter_leaves` of its error, since 0.7^4 = 0.24. The bound on the steps stays once it is below
// `least_share` of the usual one.
constexpr double mostly_cut = 0.9, shorter = 0.7, shorter_leaves = 0.25, least_share = 0.25;

// How often a run is repeated that reached its accuracy but has an untrusted certificate.
constexpr int most_doubts = 3;

/// The angle between two orientations, from the chord of their quaternions.
double turn_between(const Quaternion& p, const Quaternion& q) {
  return 4 * std::asin(std::min(1.0, 0.5 * std::min((p - q).norm(), (p + q).norm())));
}

void compare(const System& system, const Samples& a, const Samples& b, std::size_t i, Difference& worst) {
  const auto take = [&](double size, std::size_t coordinate) {
    if (size <= worst.size) return;
    worst = {size, a.times[i], int(coordinate)};
  };
  for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
    const CoordinateInfo& info = system.coordinates[c];
    const double unit = system.velocity_scale[info.v_index];
    if (info.q_size == 4) {
      take(turn_between(a.q[i].segment<4>(info.q_index), b.q[i].segment<4>(info.q_index)), c);
    } else {
      const double p = a.q[i][info.q_index], q = b.q[i][info.q_index];
      take(std::abs(p - q) / (info.angle ? unit : std::max(unit, std::abs(q))), c);
    }
    for (int k = info.v_index; k < info.v_index + info.v_size; ++k)
      take(std::abs(a.v[i][k] - b.v[i][k]) / (unit + std::abs(b.v[i][k])), c);
  }
}

/// The largest difference of an independent group's positions or velocities, relative to the largest motion
/// of any of its coordinates in run b, on the scale of differences. Only groups that differ by more than
/// `least` count. Single coordinates are not judged: one that hardly moves says nothing.
double largest_part(const System& system, const Samples& a, const Samples& b, double least) {
  struct Most {
    double difference = 0, moved = 0;
  };
  std::vector<Most> positions(system.groups), velocities(system.groups);
  const auto take = [](double difference, double moved, Most& most) {
    most.difference = std::max(most.difference, difference);
    most.moved = std::max(most.moved, moved);
  };
  const std::size_t count = std::min(a.q.size(), b.q.size());
  for (const CoordinateInfo& info : system.coordinates) {
    const double unit = system.velocity_scale[info.v_index];
    const int n = info.q_index, group = system.velocity_groups[info.v_index];
    const double range = (b.q_high - b.q_low).segment(n, info.q_size).norm();
    for (std::size_t i = 0; i < count; ++i) {
      if (info.q_size == 4)
        take(turn_between(a.q[i].segment<4>(n), b.q[i].segment<4>(n)), 2 * range, positions[group]);
      else
        take(std::abs(a.q[i][n] - b.q[i][n]) / unit, range / unit, positions[group]);
      for (int k = info.v_index; k < info.v_index + info.v_size; ++k)
        take(std::abs(a.v[i][k] - b.v[i][k]) / unit, std::max(b.v_high[k], -b.v_low[k]) / unit,
             velocities[group]);
    }
  }
  double largest = 0;
  for (const auto* of : {&positions, &velocities})
    for (const Most& most : *of)
      if (most.difference > least) largest = std::max(largest, most.difference / most.moved);
  return largest;
}

/// Whether efforts or velocities jumped during the run.
bool is_rough(const Certificate& c) {
  return std::any_of(c.events.begin(), c.events.end(), [](const LoggedEvent& e) {
    return e.kind != "range_left" && e.kind != "range_entered";  // these have no effect
  });
}

}  // namespace

Difference largest_difference(const System& system, const Samples& a, const Samples& b) {
  Difference worst;
  for (std::size_t i = 0; i < std::min(a.q.size(), b.q.size()); ++i) compare(system, a, b, i, worst);
  return worst;
}

namespace {

/// The search for method and tolerance, run by run.
class Search {
 public:
  Search(const System& system, double start, const SimulationSettings& settings)
      : system_(system), start_(start), settings_(settings), chosen_(settings) {
    chosen_.accuracy = 0;
    // A multistep method does not allow projections between steps.
    implicit_ =
        system.rows > 0 && settings.constraints == ConstraintTreatment::projection ? "arkode" : "cvode";
    choose_explicit();
  }

  Result<Trajectory> run(const RunOnce& run, const std::function<bool()>& stopped) {
    for (;;) {
      Samples samples;
      samples.times = times();
      SimulationSettings how = chosen_;
      // a tolerance far below the accuracy does not promise a better energy balance
      if (how.energy_threshold == 0)
        how.energy_threshold = std::max(std::min(settings_.accuracy, 1e-3), energy_threshold(chosen_, true));
      if (!before_ && !settings_.verify && chosen_.method != implicit_)
        // this run is not the answer, so its rows are not needed
        how.output_interval = settings_.end_time - start_;
      const double off = chosen_.method == implicit_ ? off_implicit : off_explicit;
      limits_.disturbance = before_ || exact_ ? 0 : off * chosen_.tolerance;
      const double share = limits_.step_share;
      auto now = run(how, limits_, samples);
      spent_ += double(samples.evaluations);
      ++runs_;
      if (!now && !before_ && !exact_ && !stopped()) {
        if (chosen_.tolerance > first_)  // it may be too coarse
          next_tolerance(std::max(0.1, first_ / chosen_.tolerance));
        else
          exact_ = parted_ = true;  // the disturbed motion may end where the undisturbed one does not
        ended_ = fmt::format("with the start disturbed by {:.2g}, the run ends: {}", limits_.disturbance,
                             now.error().message());
        continue;
      }
      if (!now || stopped()) return now;
      if (samples.q.size() < samples.times.size()) {
        change_method(now->certificate, double(samples.times.size()) / (double(samples.q.size()) + 0.5));
        before_.reset();
        continue;
      }
      limits_.evaluations = std::numeric_limits<double>::infinity();  // this method reaches the end,
      limits_.leave_if_stiff = false;                                 // and finer runs are less stiff
      if (!before_ && wasteful(now->certificate)) {
        choose_explicit();
        why_ = fmt::format("{}, but {} dissipates the motion", found_, implicit_);
        continue;
      }
      rough_ = rough_ || (!settings_.verify && is_rough(now->certificate));
      if (before_) {
        common_ = largest_part(system_, *before_, samples, settings_.accuracy) <= apart_in_range;
        cut_before_ = before_->cut_part();
        if (judge(largest_difference(system_, *before_, samples), agree_until(*before_, samples), *now))
          return now;
      }
      if (afresh_) {
        afresh_ = false;
        before_.reset();
        limits_.step_share = 1;
        continue;
      }
      if (!before_)
        next_tolerance(std::exchange(exact_, false) ? after_apart
                                                    : std::min(0.1, first_ / chosen_.tolerance));
      if (settings_.verify && samples.cut_part() > mostly_cut) shorten();
      before_ = std::move(samples);
      share_before_ = share;
    }
  }

 private:
  /// The last time, s, up to which the two runs agree to the accuracy. If the accuracy is not reached,
  /// rounding may dominate the finer run's error, so its estimate is not below the difference.
  double agree_until(const Samples& before, const Samples& now) const {
    double until = start_;
    Difference worst;
    for (std::size_t i = 0; i < std::min(before.q.size(), now.q.size()); ++i) {
      compare(system_, before, now, i, worst);
      if (worst.size > settings_.accuracy) break;
      until = now.times[i];
    }
    return until;
  }

  std::vector<double> times() const {
    std::vector<double> out;
    if (!(settings_.end_time > start_)) return out;
    const double whole = settings_.end_time - start_, interval = settings_.output_interval;
    if (interval > 0 && interval < whole) {  // at output rows, which exist anyway
      const double rows = whole / interval;
      const double each = std::ceil(rows / comparisons);
      for (double i = each; i < rows * (1 - 1e-9); i += each) out.push_back(start_ + i * interval);
      out.push_back(settings_.end_time);
      return out;
    }
    for (int i = 1; i < comparisons; ++i)
      out.push_back(start_ + (settings_.end_time - start_) * i / comparisons);
    out.push_back(settings_.end_time);
    return out;
  }

  void choose_explicit() {
    chosen_.method = "dop853";
    why_ = "the cheapest method if a scene is not stiff";
    least_ = least_explicit;
    choose_tolerance();
  }

  void choose_tolerance() {
    first_ = chosen_.tolerance = std::max(0.1 * settings_.accuracy, 10 * least_);
    if (settings_.verify) return;
    first_ = std::clamp(to_do * settings_.accuracy, least_, loosest);
    chosen_.tolerance = std::min(pilot * first_, coarsest);
  }

  /// Switches to the other kind of method. The whole of the abandoned run would take `times` as long. An
  /// implicit method may spend that many evaluations; the explicit one five times those spent so far.
  void change_method(const Certificate& left, double times) {
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
      choose_tolerance();
    }
    limits_.leave_if_stiff = false;
    limits_.step_share = 1;
    if (!from_implicit) left_would_take_ = times * double(left.evaluations);
    limits_.evaluations = from_implicit ? worth_a_try * spent_ : left_would_take_;
  }

  /// Whether the first run of an implicit method lost much of the energy turnover and was not much cheaper
  /// than the explicit run would have been: undamped oscillations cost it as much.
  bool wasteful(const Certificate& c) const {
    return chosen_.method == implicit_ && c.energy_drift > much_lost * c.energy_turnover &&
           left_would_take_ < much_cheaper * double(c.evaluations);
  }

  bool may_shorten() const { return limits_.step_share > least_share; }
  void shorten() {
    if (may_shorten()) limits_.step_share *= shorter;
  }
  /// Whether the run under judgement has shorter steps than the one before it.
  bool has_shorter_steps() const { return limits_.step_share < share_before_; }

  void next_tolerance(double factor) {
    tolerance_before_ = chosen_.tolerance;
    chosen_.tolerance = std::max(chosen_.tolerance * factor, least_);
  }

  void tell(Certificate& c, double error, const std::string& how_known) const {
    c.accuracy = settings_.accuracy;
    c.estimated_error = error;
    if (parted_ && !ended_.empty()) c.notes.push_back(ended_);
    c.notes.push_back(fmt::format("accuracy {:.3g}: chose {} ({}) at tolerance {:.2g}; {}",
                                  settings_.accuracy, chosen_.method, why_, chosen_.tolerance, how_known));
  }

  /// The run's error, from its difference to the coarser run before it. Infinite if the two runs part.
  double error_of(double difference) const {
    if (!settings_.verify && !common_) return std::numeric_limits<double>::infinity();
    // two runs with the same steps do not show the error
    if (cut_before_ > mostly_cut && !has_shorter_steps() && (settings_.verify || limits_.step_share < 1))
      return std::numeric_limits<double>::infinity();
    if (has_shorter_steps() && !settings_.verify) {
      const bool regular = chosen_.method != implicit_ && !rough_ && !parted_;
      return difference * (regular ? shorter_leaves / (1 - shorter_leaves) : 1);
    }
    // The tolerance acts only on the part of the first run's steps that was not cut.
    const double follows = settings_.verify ? 1 : 1 - std::min(cut_before_, mostly_cut);
    return error_while_near(difference) / follows;
  }
  /// The same while the two runs follow the same motion.
  double error_while_near(double difference) const {
    const double share = chosen_.tolerance / tolerance_before_;
    // If errors are proportional to tolerances, the finer run's error is share / (1 - share) of the
    // difference. With `verify`, at least the whole difference counts.
    if (settings_.verify) return difference * std::max(1.0, share / (1 - share));
    if (difference > apart) return std::numeric_limits<double>::infinity();
    const double part = rough_    ? std::sqrt(share)
                        : parted_ ? std::max(share, after_parting * std::sqrt(share))
                                  : share;
    return difference * part / (1 - share);
  }

  /// Whether the run is the answer; otherwise chooses the next tolerance.
  bool judge(const Difference& found, double agree, Trajectory& now) {
    const double error = error_of(found.size);
    const bool reached = error <= settings_.accuracy;
    parted_ = parted_ || !std::isfinite(error);
    const bool by_steps = has_shorter_steps() && !settings_.verify;
    if (!settings_.verify && may_shorten() && (by_steps ? !reached : reached && cut_before_ > mostly_cut)) {
      shorten();
      next_tolerance(0.1);
      return false;
    }
    if (!reached && chosen_.tolerance > worth_lowering * least_) {
      const bool far = rough_ && chosen_.tolerance * near_pilot < 0.99 * tolerance_before_;
      next_tolerance(far ? 0.1
                     : std::isfinite(error)
                         ? std::clamp(0.3 * settings_.accuracy / error, 1e-3, parted_ && !rough_ ? 0.03 : 0.1)
                         : after_apart);
      // Two similar runs of an implicit method may both damp what is below their tolerances.
      afresh_ = chosen_.method == implicit_ && chosen_.tolerance > 10 * worth_lowering * least_;
      return false;
    }
    Certificate& c = now.certificate;
    if (reached && !c.trusted && doubted_ < most_doubts && chosen_.tolerance > worth_lowering * least_) {
      ++doubted_;  // energy and momenta may need a tighter tolerance than the accuracy
      const double lower = 0.3 * c.energy_threshold * c.energy_turnover / c.energy_drift;
      next_tolerance(lower < 0.1 ? std::max(lower, 1e-3) : 0.1);
      if (by_steps) shorten();
      return false;
    }
    c.evaluations = long(spent_);
    c.known_until = reached ? settings_.end_time : agree;
    tell(c, std::isfinite(error) ? error : found.size,
         fmt::format("differs from the run at {:.2g}{} by {:.2g}; {} evaluations in all {} runs",
                     tolerance_before_, by_steps ? " with longer steps" : "", found.size, c.evaluations,
                     runs_));
    if (reached || !c.trusted) return true;
    const CoordinateInfo& worst = system_.coordinates[found.coordinate];
    c.trusted = false;
    const double near = 1e-6 * (settings_.end_time - start_);
    const auto event = std::find_if(c.events.begin(), c.events.end(), [&](const LoggedEvent& e) {
      return std::abs(e.time - found.time) < near;
    });
    c.reason = fmt::format(
        "the accuracy of {:.3g} could not be shown: runs at tolerances {:.2g} and {:.2g} differ by {:.2g} in "
        "coordinate '{}' of '{}' at t = {:.6g} s; {}",
        settings_.accuracy, tolerance_before_, chosen_.tolerance, found.size, worst.name, worst.solid,
        found.time,
        event == c.events.end()
            ? "shorten the run, or give a lower accuracy"
            : fmt::format("an event ({} '{}') falls on that time, so one run shows the state before it and "
                          "the other the state after; choose other output times",
                          event->kind, event->name));
    c.reason += fmt::format("; the state is known to that accuracy up to t = {:.6g} s", agree);
    c.reason_time = found.time;
    return true;
  }

  const System& system_;
  double start_;
  const SimulationSettings& settings_;
  SimulationSettings chosen_;
  const char* implicit_;
  RunLimits limits_{.leave_if_stiff = true, .own_first_step = true};
  std::string why_, found_, ended_;
  double least_ = 0, tolerance_before_ = 0;
  double first_ = 0;            ///< first tolerance for the answer, if a coarser run judges it
  double spent_ = 0;            ///< evaluations so far
  double left_would_take_ = 0;  ///< evaluations that the abandoned run would take at its steps
  int runs_ = 0;
  bool afresh_ = false;      ///< the next run is again the first of two
  bool exact_ = false;       ///< the first run is undisturbed, because disturbed it failed
  bool common_ = true;       ///< the last two runs agree, relative to the range of motion
  bool parted_ = false;      ///< two runs had nothing in common
  bool rough_ = false;       ///< a run met stops or contacts
  int doubted_ = 0;          ///< number of runs repeated for an untrusted certificate
  double cut_before_ = 0;    ///< part of the steps of the run before that functions of time cut
  double share_before_ = 1;  ///< RunLimits::step_share of the run before
  std::optional<Samples> before_;
};

}  // namespace

Result<Trajectory> run_to_accuracy(const System& system, double start, const SimulationSettings& settings,
                                   const RunOnce& run, const std::function<bool()>& stopped) {
  return Search(system, start, settings).run(run, stopped);
}

}  // namespace borelli
