// Work-precision of a scene: cost and error of each method's runs over a ladder of steps or tolerances.
//
// Error of a run, over output times that all runs share: the largest distance of any solid's gravity centre
// from the reference's, over the scene's length (System::length), and the largest angle between their
// orientations. The reference is given, or comes from two unlike methods at extreme tolerances; their
// difference is its error. If rounding makes the two diverge, as in chaos, runs end before that. If fewer
// than a quarter of the output times remain, as many are distributed anew over the remaining time.
//
// In scenes with contacts, methods and programs solve different laws. Such scenes compare times of impacts
// (over the run's length), momentum, penetration (over the scene's length) and energy; the largest counts
// (judged_error).
//
// If a run's steps are longer than the output spacing, it is compared at the outputs where its steps end.
//
// Methods of other programs may join the chart: they give poses at the output times and are judged by the
// same errors.
//
// Errors and evaluations are the same, bit for bit, from one call to the next on one machine; only the
// seconds differ.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/scene/scene.hpp"
#include "pipeline/charts/reference_search.hpp"
#include "pipeline/export/reference_file.hpp"

namespace borelli {

/// Processor time of this thread, s.
double processor_time();

/// Name of the method that chooses method and tolerance for a requested accuracy
/// (SimulationSettings::accuracy, without a verifying run). It is on the chart but not on the Pareto front,
/// since its runs are other methods' runs.
inline constexpr std::string_view automatic = "auto";

struct Variant {
  std::string method;  ///< of integrator_names(), or automatic
  Equations equations = Equations::recursive;
  ConstraintTreatment constraints = ConstraintTreatment::projection;
  bool adaptive = false;  ///< the setting is a tolerance, not a step
  bool other = false;     ///< of another program: `method` names program and method
};

/// Result of another program's run of the scene.
struct OtherRun {
  std::vector<Pose> poses;  ///< X_WS of each solid, in the scene's order: [time * solids + solid]
  double seconds = 0;       ///< processor time, s, without the set-up before the first step
  long evaluations = 0;
  double energy = 0, constraint = 0;          ///< as in RunErrors; NaN: not comparable
  std::vector<double> impacts = {};           ///< times of impacts, s; empty: not reported
  std::vector<Eigen::Vector3d> momenta = {};  ///< total, kg m/s, at the output times; empty: not reported
};

/// A method of another program that can run the scene.
struct OtherMethod {
  std::string name;  ///< of program and method
  bool adaptive = false;
  /// Runs from the scene's start to each of `times` (s) with a step (s) or tolerance. The run must call
  /// `go_on` from time to time and stop when it returns false.
  std::function<Result<OtherRun>(double setting, const std::vector<double>& times,
                                 const std::function<bool()>& go_on)>
      run;
};

struct WorkPrecisionSettings {
  std::vector<std::string> methods = {};  ///< of integrator_names(), automatic; empty: all
  std::vector<Equations> equations = {Equations::recursive, Equations::lagrange};
  /// Only the first counts if the scene has no constraints.
  std::vector<ConstraintTreatment> constraints = {ConstraintTreatment::projection,
                                                  ConstraintTreatment::baumgarte};
  int outputs = 20;    ///< number of output times, evenly spaced over the scene's time
  int repeats = 3;     ///< runs per point; the median of their times counts
  int per_decade = 1;  ///< tolerances per decade, for methods with a tolerance
  /// s of processor time; a ladder ends with the first run that exceeds it. All ladders are climbed within a
  /// 25th of it, then a fifth, then all of it, so that a coarse chart of all methods is there early.
  double budget = 0.5;
  /// A reference that contains the output times; if absent, one is made.
  std::optional<GivenReference> reference = {};
};

/// Dimensionless unless a unit is stated. NaN: nothing to compare.
struct RunErrors {
  double position, orientation;  ///< over the scene's length; rad
  double energy;                 ///< largest drift over the turnover
  double constraint;             ///< largest residual of a row, in the row's unit (m or rad)
  double impacts;                ///< s: error of the times of impacts (impact_time_error)
  /// Scenes with contacts: error of the total linear momentum at the output times, over the reference's
  /// largest.
  double momentum = std::numeric_limits<double>::quiet_NaN();
};

struct WorkPrecisionPoint {
  std::size_t variant;      ///< index into WorkPrecision::variants
  double setting;           ///< step (s), or what setting_name() says
  bool finished = false;    ///< the run reached its end
  bool trusted = false;     ///< by its certificate; another program's run: it finished
  std::string reason = {};  ///< why it did not finish or is not trusted
  double seconds = 0;       ///< processor time, median, s
  long evaluations = 0;     ///< 0 if it did not finish
  RunErrors errors = {};    ///< if it finished
};

struct WorkPrecision {
  std::string scene;
  bool has_constraints = false, has_impacts = false;
  double length = 1, duration = 1;  ///< m, of the scene; s, of the runs
  Reference reference;
  /// Share of the budget within which the ladders were climbed; below 1: finer runs follow.
  double share = 1;
  std::vector<Variant> variants;           ///< other programs' last
  std::vector<WorkPrecisionPoint> points;  ///< by variant, from coarse to fine
};

/// "dop853", then what differs from the default: "dop853, lagrange, baumgarte".
std::string name_of(const Variant& variant);

/// Meaning of the setting: "step" (s), "tolerance" or, for automatic, "accuracy".
std::string_view setting_name(const Variant& variant);

/// Earlier results of an interrupted run, and callbacks with the results so far. An error that a callback
/// returns ends the chart.
struct WorkPrecisionObserver {
  std::function<void(const std::string& what, double fraction)> progress = [](const std::string&, double) {};
  std::vector<WorkPrecisionPoint> known = {};  ///< runs that need not be made again
  /// Called after each ladder with its points, so that an interrupted run can be resumed.
  std::function<Result<void>(const std::vector<WorkPrecisionPoint>&)> ladder_ends =
      [](const std::vector<WorkPrecisionPoint>&) { return Result<void>(); };
  /// Called after all ladders were climbed within a share of the budget, except the last share. The chart is
  /// complete but coarse; finer ones follow.
  std::function<Result<void>(const WorkPrecision&)> round_ends = [](const WorkPrecision&) {
    return Result<void>();
  };
};

/// Runs the scene through all variants and through `others`. Errors: the scene does not compile, a setting
/// makes no sense, a given reference has no row at an output time, or a callback returns an error. A run that
/// fails becomes a point with its reason.
Result<WorkPrecision> work_precision(const Scene& scene, const WorkPrecisionSettings& settings,
                                     const WorkPrecisionObserver& observer = {},
                                     const std::vector<OtherMethod>& others = {});

/// Selects the points of our methods or of other programs.
enum class Whose { ours, others };

/// Error of a run as one number: the larger of position (over the scene's length) and orientation (rad). For
/// scenes with contacts: the largest known of times of impacts, momentum, penetration and energy (see above).
/// NaN: there is no reference.
double judged_error(const WorkPrecision& chart, const WorkPrecisionPoint& point);

/// Ten times the reference's own error: smaller errors cannot be resolved.
double reference_floor(const WorkPrecision& chart);

/// Trusted points that no other point of the same group beats in both `cost` and `error`. Errors below
/// `floor` count as `floor`. Sorted by falling error.
std::vector<const WorkPrecisionPoint*> pareto_front(
    const WorkPrecision& chart, const std::function<double(const WorkPrecisionPoint&)>& cost,
    const std::function<double(const WorkPrecisionPoint&)>& error, double floor, Whose whose = Whose::ours);

/// The fastest trusted run with an error of at most `error` (judged_error). Null: none, or the reference is
/// not ten times as accurate.
const WorkPrecisionPoint* fastest_within(const WorkPrecision& chart, double error, Whose whose = Whose::ours);

/// Error of a run's times of impacts `a` against the reference's, s, up to the time `end`. The two lists are
/// matched in order. An unmatched impact counts with the time since the other list's last impact (since
/// `start` if it has none). NaN: both lists are empty.
double impact_time_error(const std::vector<double>& a, const std::vector<double>& reference, double start,
                         double end);

}  // namespace borelli
