#include "pipeline/charts/reference_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/simulate.hpp"

namespace borelli {

std::vector<MotionDifference> motion_differences(const Trajectory& a, const Trajectory& b,
                                                 const std::vector<Eigen::Vector3d>& centres, double length) {
  std::vector<MotionDifference> out(1);
  for (std::size_t row = 1; row < std::min(a.times.size(), b.times.size()); ++row) {
    out.push_back(motion_difference(&a.pose(row, 0), &b.pose(row, 0), centres));
    out.back().position /= length;
    out.back().widen(out[row - 1]);
  }
  return out;
}

double size_of(const MotionDifference& d) { return std::max(d.position, d.orientation); }

namespace {

// Two runs are a reference as long as they differ by no more than the first limit. If that does not last to
// the end but a looser limit does, the looser one counts: errors above it are judged over the whole time. Not
// if the runs diverge: then a little more time would cost all accuracies but the loosest.
constexpr double reference_limits[] = {1e-8, 1e-7, 1e-6, 1e-5};

// a reference may take this multiple of a run's budget
constexpr double reference_patience = 100;

// if fewer than one in `scanty` outputs remain, they are distributed anew over the remaining time
constexpr std::size_t scanty = 4;

// two runs whose difference grows faster than this power of time diverge, as in chaos
constexpr double steepest_growth = 6;

constexpr double reference_tolerances[] = {1e-11, 1e-12, 1e-13, 1e-14};

// Approximate time of one evaluation of the equations, s. It turns a time budget into a reproducible number
// of evaluations.
double evaluation_time(const System& system) {
  const double n = system.nv, rows = system.rows;
  return 2e-7 * (2 + n) + 1e-8 * rows * rows;
}

class Search {
 public:
  Search(const System& system, const std::vector<Eigen::Vector3d>& centres, const SimulationSettings& how,
         const ReferenceRequest& asked)
      : system_(system), centres_(centres), asked_(asked), how_(how) {
    span_ = how_.end_time - system.initial.t;
    how_.output_interval = span_ / asked.outputs;
  }

  FoundReference run() {
    search();
    if (asked_.anew) lay_outputs_anew();
    found_.end_time = how_.end_time;
    found_.output_interval = how_.output_interval;
    return std::move(found_);
  }

 private:
  /// A candidate for the reference, computed once: the `rung`-th of a ladder of tolerances or steps. Null: it
  /// fails or takes too long.
  const Trajectory* reference_run(const std::string& method, std::size_t rung) {
    const auto [place, is_new] = made_.try_emplace({method, rung});
    std::optional<Trajectory>& out = place->second;
    if (!is_new) return out ? &*out : nullptr;
    SimulationSettings how = how_;
    how.method = method;
    how.tolerance = reference_tolerances[rung];
    how.step = how_.output_interval / (8 * std::pow(4, double(rung)));
    asked_.progress(fmt::format("reference: {}", reference_words(method, rung)));
    Observer observer;
    observer.limits.evaluations = reference_patience * asked_.budget / evaluation_time(system_);
    // (explicit methods are expensive on a stiff scene: other methods are tried first)
    observer.limits.leave_if_stiff = !stay_though_stiff_;
    auto t = simulate(system_, system_.initial, how, observer);
    if (!t)
      why_not_ = t.error().message();
    else if (t->times.back() < how.end_time * (1 - 1e-12))
      why_not_ =
          fmt::format("{} would take more than {:.2g} evaluations", method, observer.limits.evaluations),
      stiff_ = stiff_ || std::isfinite(t->certificate.stiff_from);
    else  // a verdict may demand more than a reference can give; agreement of two unlike methods is proof
      out = std::move(*t);
    if (!out && rung == 0) fails_.insert(method);
    return out ? &*out : nullptr;
  }

  std::string reference_words(const std::string& method, std::size_t rung) const {
    return method_is_adaptive(method)
               ? fmt::format("{} at tolerance {:g}", method, reference_tolerances[rung])
               : fmt::format("{} at step {:.3g} s", method,
                             how_.output_interval / (8 * std::pow(4, double(rung))));
  }

  /// The last row up to which two runs agree within a limit.
  static std::size_t agreement(const std::vector<MotionDifference>& d, double limit) {
    std::size_t row = 0;
    while (row + 1 < d.size() && size_of(d[row + 1]) < limit) ++row;
    return row;
  }

  /// Whether the difference of two runs grows faster than steepest_growth between two rows (both after the
  /// first).
  static bool part_ever_faster(const std::vector<MotionDifference>& d, std::size_t from, std::size_t to) {
    const double before = size_of(d[from]), after = size_of(d[to]);
    return before > 0 && std::log(after / before) > steepest_growth * std::log(double(to) / double(from));
  }

  /// Two runs, and the last row up to which they agree within a limit.
  struct Agreed {
    std::string first, second;
    std::size_t rung = 0, row = 0;
    double limit = 0;
    std::vector<MotionDifference> differences = {};
    double size() const { return size_of(differences[row]); }
  };

  /// The pair that agrees within a limit for longest; ties go to the closest pair.
  static Agreed longest(const std::vector<Agreed>& pairs, double limit) {
    Agreed best;
    for (Agreed now : pairs) {
      now.limit = limit;
      now.row = agreement(now.differences, limit);
      if (best.differences.empty() || now.row > best.row || (now.row == best.row && now.size() < best.size()))
        best = std::move(now);
    }
    return best;
  }

  std::optional<Agreed> try_pair(const std::string& first, const std::string& second) {
    std::vector<Agreed> pairs;
    for (std::size_t rung = 0; rung < std::size(reference_tolerances); ++rung) {
      if (fails_.contains(first) || fails_.contains(second)) break;
      const Trajectory* a = reference_run(first, rung);
      const Trajectory* b = a ? reference_run(second, rung) : nullptr;
      if (!b) break;
      pairs.push_back({.first = first,
                       .second = second,
                       .rung = rung,
                       .differences = motion_differences(*a, *b, centres_, system_.length)});
    }
    if (pairs.empty()) return {};
    const auto last = std::size_t(asked_.outputs);
    Agreed best = longest(pairs, reference_limits[0]);
    if (best.row < last && !part_ever_faster(best.differences, best.row / 2 + 1, last))
      for (std::size_t i = 1; i < std::size(reference_limits) && best.row < last; ++i)
        if (Agreed looser = longest(pairs, reference_limits[i]); looser.row == last) best = std::move(looser);
    if (best.row == 0) {
      if (best.differences.size() > 1 && parted_.empty())
        parted_ = fmt::format(
            "{} and {} differ by {:.2g} at the first output time, t = {:.4g} s, as chaotic motion does; "
            "shorten the run or give more output times",
            reference_words(first, best.rung), reference_words(second, best.rung),
            size_of(best.differences[1]), system_.initial.t + how_.output_interval);
      return {};
    }
    return best;
  }

  void search() {
    // unlike one-step methods of high order; implicit ones if these fail
    const char* stiff = system_.rows > 0 ? "arkode" : "cvode";
    const char* unlike = system_.rows > 0 ? "gauss6" : "arkode";
    using Pair = std::pair<const char*, const char*>;
    const std::vector<Pair> implicit{{stiff, unlike}}, mixed{{"dop853", stiff}, {"gbs", stiff}};
    std::optional<Agreed> best;
    const auto try_all = [&](const std::vector<Pair>& pairs) {
      for (const auto& [first, second] : pairs)
        if (!best && (parted_.empty() || stiff_)) best = try_pair(first, second);
    };
    try_all({{"dop853", "gbs"}});
    if (stiff_) {
      try_all(implicit);
      if (!best) made_.clear(), fails_.clear(), stay_though_stiff_ = true;
      try_all({{"dop853", "gbs"}});
    }
    try_all(mixed);
    try_all({{"dop853", "dopri5"}, {"dopri5", "rk4_adaptive"}});
    try_all(implicit);
    Reference& reference = found_.reference;
    found_.last_row = std::size_t(asked_.outputs);
    if (!best) {
      const bool none = std::none_of(made_.begin(), made_.end(), [](const auto& m) { return m.second; });
      reference.words = none ? fmt::format("No reference: no method completes the run ({}).", why_not_)
                             : fmt::format("No reference: {}. Only energy and constraints are judged.",
                                           parted_.empty() ? "no two different methods finished" : parted_);
      return;
    }
    const MotionDifference& worst = best->differences[best->row];
    reference = {
        .found = true,
        .runs = {reference_words(best->first, best->rung), reference_words(best->second, best->rung)},
        .position = worst.position,
        .orientation = worst.orientation,
        .horizon = system_.initial.t + double(best->row) * how_.output_interval,
        .words = {}};
    found_.motion = std::move(made_.at({best->first, best->rung}));
    made_.clear();
    reference.words =
        fmt::format("Reference: {}; {} differs from it by {:.1g} of the scene's length and {:.1g} rad.",
                    reference.runs[0], reference.runs[1], reference.position, reference.orientation);
    if (best->row < found_.last_row) {
      const bool faster = part_ever_faster(best->differences, best->row / 2 + 1, found_.last_row);
      chaotic_ = chaotic_ || faster;
      reference.words += fmt::format(
          " Beyond t = {:.4g} s (of {:.4g} s) they differ by more than {:g}{}, so the runs end there.",
          reference.horizon, how_.end_time, best->limit,
          faster ? ", at a growing rate, as in chaos or near an unstable position" : "");
    }
    found_.last_row = best->row;
  }

  /// If the references diverge early, hardly any output remains to judge runs at; as many outputs are
  /// distributed over the remaining time.
  void lay_outputs_anew() {
    constexpr int most = 4;
    for (int round = 0; round < most; ++round) {
      const bool found = found_.reference.found;
      if (found ? found_.last_row * scanty > std::size_t(asked_.outputs) : parted_.empty()) return;
      chaotic_ = chaotic_ || !found;
      const std::size_t left = found ? found_.last_row : 1;  // before the first output they may agree
      how_.end_time = system_.initial.t + double(left) * how_.output_interval;
      how_.output_interval = (how_.end_time - system_.initial.t) / asked_.outputs;
      found_.reference = {};
      found_.motion.reset();
      made_.clear(), fails_.clear(), parted_.clear(), why_not_.clear();
      stiff_ = stay_though_stiff_ = false;
      search();
      if (found_.reference.found)
        found_.reference.words += fmt::format(
            " Over the requested {:.4g} s they diverge too early{}, so the runs are compared at {} times up "
            "to t = {:.4g} s.",
            span_, chaotic_ ? ", as in chaos" : "", found_.last_row, found_.reference.horizon);
    }
  }

  const System& system_;
  const std::vector<Eigen::Vector3d>& centres_;
  const ReferenceRequest& asked_;
  SimulationSettings how_;
  double span_ = 0;       ///< s, intended length of the runs
  bool chaotic_ = false;  ///< over that time the references diverge
  // runs by method and rung, and results of the search
  std::map<std::pair<std::string, std::size_t>, std::optional<Trajectory>> made_;
  std::set<std::string> fails_;
  bool stiff_ = false, stay_though_stiff_ = false;
  std::string why_not_;
  std::string parted_;  ///< two finished runs that differ from the first output on: by how much
  FoundReference found_;
};

}  // namespace

FoundReference find_reference(const System& system, const std::vector<Eigen::Vector3d>& centres,
                              const SimulationSettings& how, const ReferenceRequest& request) {
  return Search(system, centres, how, request).run();
}

}  // namespace borelli
