// Work-precision of a scene: what each method's runs cost, over a ladder of steps or tolerances, and how far
// they are off.
//
// Error of a run: over output times that all runs share, the largest distance of any solid's gravity centre
// from the reference's, over the scene's length (System::length), and the largest angle between their
// orientations. The reference is given, or made by two unlike methods at extreme tolerances; what they differ
// by is its error. Where rounding alone parts the two ever faster, as in chaos, runs end before that; where
// fewer than a quarter of the output times are left then, as many are laid anew over what is left.
//
// Scenes with contacts, where methods and programs solve different laws, are compared by the times of impacts
// (over the run's length), momentum, penetration (over the scene's length) and energy, of which the largest
// counts (judged_error).
//
// A run whose steps are longer than the time between outputs is compared at the outputs that its steps end
// on.
//
// Methods of other programs may stand on the same chart: they give poses at the output times, and are
// measured by the same errors.
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

/// s, of this thread.
double processor_time();

/// The method's name of runs to an asked accuracy (SimulationSettings::accuracy, without a run that
/// verifies), which choose method and tolerance themselves. They are on the chart, not on its front: their
/// runs are other methods'.
inline constexpr std::string_view automatic = "auto";

struct Variant {
  std::string method;  ///< of integrator_names(), or automatic
  Equations equations = Equations::recursive;
  ConstraintTreatment constraints = ConstraintTreatment::projection;
  bool adaptive = false;  ///< its setting is a tolerance, not a step
  bool other = false;     ///< of another program: `method` names both
};

/// What another program's run of the scene came to.
struct OtherRun {
  std::vector<Pose> poses;  ///< X_WS of each solid, in the scene's order: [time * solids + solid]
  double seconds = 0;       ///< of processor time, without what came before the first step
  long evaluations = 0;
  double energy = 0, constraint = 0;          ///< as in RunErrors; NaN where there is nothing to compare
  std::vector<double> impacts = {};           ///< s, when; empty: not told
  std::vector<Eigen::Vector3d> momenta = {};  ///< kg m/s, total, at the output times; empty: not told
};

/// A method of another program that can run the scene.
struct OtherMethod {
  std::string name;  ///< the program's and the method's
  bool adaptive = false;
  /// From the scene's start to each of `times` (s) with a step (s) or tolerance; `go_on` is to be asked now
  /// and then.
  std::function<Result<OtherRun>(double setting, const std::vector<double>& times,
                                 const std::function<bool()>& go_on)>
      run;
};

struct WorkPrecisionSettings {
  std::vector<std::string> methods = {};  ///< of integrator_names(), automatic; empty: all
  std::vector<Equations> equations = {Equations::recursive, Equations::lagrange};
  /// Where the scene has no constraints the first alone counts.
  std::vector<ConstraintTreatment> constraints = {ConstraintTreatment::projection,
                                                  ConstraintTreatment::baumgarte};
  int outputs = 20;     ///< times that runs are compared at, evenly spread over the scene's
  int repeats = 3;      ///< of each run; the median of their times counts
  int per_decade = 1;   ///< tolerances in one, of methods that have a tolerance
  double budget = 0.5;  ///< s of processor time; a ladder ends with the first run that takes longer
  /// A reference that holds the output times; where there is none it is made.
  std::optional<GivenReference> reference = {};
};

/// Sizes without a unit but where one is said. NaN: there is nothing to compare.
struct RunErrors {
  double position, orientation;  ///< over the scene's length; rad
  double energy;                 ///< largest drift over what was turned over
  double constraint;             ///< largest residual of a row, in the row's unit (m or rad)
  double impacts;                ///< s: of the times of impacts (impact_time_error)
  /// Of scenes with contacts: of the total linear momentum at the output times, over the reference's largest.
  double momentum = std::numeric_limits<double>::quiet_NaN();
};

struct WorkPrecisionPoint {
  std::size_t variant;      ///< in WorkPrecision::variants
  double setting;           ///< step (s), or what setting_name() says
  bool finished = false;    ///< the run came to its end
  bool trusted = false;     ///< its certificate says so; of another program: it came through
  std::string reason = {};  ///< why it did not finish or is not trusted
  double seconds = 0;       ///< of processor time, median
  long evaluations = 0;     ///< 0 where it did not finish
  RunErrors errors = {};    ///< where it finished
};

struct WorkPrecision {
  std::string scene;
  bool has_constraints = false, has_impacts = false;
  double length = 1, duration = 1;  ///< m, the scene's; s, of the runs
  Reference reference;
  std::vector<Variant> variants;           ///< other programs' last
  std::vector<WorkPrecisionPoint> points;  ///< by variant, from coarse to fine
};

/// "dop853", and what is not the default: "dop853, lagrange, baumgarte".
std::string name_of(const Variant& variant);

/// What its ladder's rungs are: "step" (s), "tolerance" or, of automatic, "accuracy".
std::string_view setting_name(const Variant& variant);

/// What a run that was broken off has found already, and who is told of each ladder that ends.
struct WorkPrecisionObserver {
  std::function<void(const std::string& what, double fraction)> progress = [](const std::string&, double) {};
  std::vector<WorkPrecisionPoint> known = {};  ///< of whole ladders
  std::function<void(const std::vector<WorkPrecisionPoint>&)> ladder_ends =
      [](const std::vector<WorkPrecisionPoint>&) {};
};

/// Runs the scene through all variants, and through `others`. Fails where the scene does not compile, a
/// setting makes no sense, or a given reference has no row at an output time; a run that fails is a point
/// with its reason.
Result<WorkPrecision> work_precision(const Scene& scene, const WorkPrecisionSettings& settings,
                                     const WorkPrecisionObserver& observer = {},
                                     const std::vector<OtherMethod>& others = {});

/// Whose points count.
enum class Whose { ours, others };

/// What a run is off by, in one number: of position (over the scene's length) and orientation (rad) the
/// larger; of scenes with contacts the largest of what is known of the times of impacts, momentum,
/// penetration and energy (see above). NaN: there is no reference.
double judged_error(const WorkPrecision& chart, const WorkPrecisionPoint& point);

/// Ten times the reference's own error: what is nearer than that to it cannot be told from it.
double reference_floor(const WorkPrecision& chart);

/// The trusted points that no other of the same makes beats in both cost and error (each on what `cost` and
/// `error` give); errors below `floor` count as that. By falling error.
std::vector<const WorkPrecisionPoint*> pareto_front(
    const WorkPrecision& chart, const std::function<double(const WorkPrecisionPoint&)>& cost,
    const std::function<double(const WorkPrecisionPoint&)>& error, double floor, Whose whose = Whose::ours);

/// The trusted run of the least time that is off by `error` at most (judged_error). Null: there is none, or
/// the reference is not ten times as good as that.
const WorkPrecisionPoint* fastest_within(const WorkPrecision& chart, double error, Whose whose = Whose::ours);

/// s: how far the times of impacts `a` of a run are from those of its reference, up to the time `end`: the
/// two lists in order; an impact that has no fellow in the other list counts with the time since the other's
/// last one (with none there, since the start). NaN: neither has any.
double impact_time_error(const std::vector<double>& a, const std::vector<double>& reference, double start,
                         double end);

}  // namespace borelli
