#include "pipeline/motion/effort_bands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <random>

#include "inertia/entries.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/motion/marker_calibration.hpp"
#include "pipeline/motion/marker_placement.hpp"
#include "pipeline/motion/scene_markers.hpp"
#include "threads/slabs.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Standard normal numbers of one draw; the same for the same seed, cause and number of the draw.
class Draw {
 public:
  Draw(unsigned seed, int cause, int number) {
    std::seed_seq words{seed, unsigned(cause), unsigned(number)};
    random_.seed(words);
  }
  double normal() { return normal_(random_); }
  Vector3d vector() {
    const double x = normal(), y = normal();
    return {x, y, normal()};
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// An entry's deviation by two causes: the density curve, which errs alike for all parts, and all others.
struct PartedDeviation {
  double shared = 0, own = 0;
};

PartedDeviation deviation_of(const InertiaTable& table, const InertiaRow& row, const std::string& entry) {
  const auto found = std::ranges::find(row.deviations, entry, &EntryDeviation::entry);
  if (found == row.deviations.end() || !std::isfinite(found->total)) return {};
  const auto cause = std::ranges::find(table.causes, "density_curve") - table.causes.begin();
  PartedDeviation out;
  if (cause < std::ssize(found->by_cause)) out.shared = found->by_cause[std::size_t(cause)];
  out.own = std::sqrt(std::max(0.0, found->total * found->total - out.shared * out.shared));
  return out;
}

/// A part's inertial moved by drawn deviations. `shared`: the draw of the density curve.
Inertial drawn_inertial(const InertiaTable& table, const InertiaRow& row, double shared, Draw& draw) {
  const auto change = [&](const std::string& entry) {
    const PartedDeviation deviation = deviation_of(table, row, entry);
    return deviation.shared * shared + deviation.own * draw.normal();
  };
  constexpr std::array<const char*, 3> axis{"x", "y", "z"};
  for (int attempt = 0; attempt < 20; ++attempt) {
    Inertial out = row.inertial;
    out.mass += change("mass_kg");
    for (int i = 0; i < 3; ++i) out.centre[i] += change(fmt::format("centre_{}_m", axis[std::size_t(i)]));
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        out.tensor(i, j) +=
            change(fmt::format("patient_I{}{}_kgm2", axis[std::size_t(i)], axis[std::size_t(j)]));
        out.tensor(j, i) = out.tensor(i, j);
      }
    if (check_physical(out, row.part)) return out;
  }
  return row.inertial;
}

PartInertials drawn_parts(const InertiaTable& table, const PartInertials& present, Draw& draw) {
  const double shared = draw.normal();
  PartInertials out;
  for (const InertiaRow& row : table.rows)
    if (present.contains(row.part)) out[row.part] = drawn_inertial(table, row, shared, draw);
  return out;
}

Landmarks drawn_landmarks(Landmarks landmarks, Draw& draw) {
  for (auto& [name, mark] : landmarks) mark.point += mark.deviation * draw.vector();
  return landmarks;
}

/// Repeats the whole computation of the motion with another body or other markers.
class Redrawn {
 public:
  Redrawn(const CapturedMotion& motion, const BodySource& source, const EffortBandRequest& request)
      : motion_(motion), source_(source), request_(request) {
    std::vector<Warning> known_warnings;
    present_ = movable_parts(source.table, known_warnings);
    options_.leap.reset();
    for (const auto& [name, inertial] : present_) segments_.push_back(name);
  }

  /// Efforts (#times by nv) of one draw.
  Result<Rows> efforts(int cause, int number) const {
    Draw draw(request_.seed, cause, number);
    if (cause == 0) return of_masses(draw);
    if (cause == 1) return of_joint_centres(draw);
    return of_markers(draw);
  }

 private:
  Result<Rows> of_masses(Draw& draw) const {
    auto skeleton = build_skeleton(drawn_parts(source_.table, present_, draw), source_.landmarks, options_);
    if (!skeleton) return tl::unexpected(skeleton.error());
    return efforts_at(skeleton->scene, motion_.positions);
  }

  Result<Rows> of_joint_centres(Draw& draw) const {
    const Landmarks landmarks = drawn_landmarks(source_.landmarks, draw);
    auto skeleton = build_skeleton(present_, landmarks, options_);
    if (!skeleton) return tl::unexpected(skeleton.error());
    const BodyMarkers markers =
        body_markers(motion_.markers.names, landmarks, segments_, source_.kind, source_.own_markers);
    auto placed = place_markers(skeleton->scene, markers.markers, motion_.trial, {false, motion_.standing});
    if (!placed) return tl::unexpected(placed.error());
    if (!motion_.calibrated) return fitted(placed->scene);
    const auto calibrated = calibrated_markers(placed->scene, motion_.markers);
    if (!calibrated) return tl::unexpected(calibrated.error());
    return fitted(calibrated->scene);
  }

  Result<Rows> of_markers(Draw& draw) const {
    Scene scene = motion_.scene;
    for (std::size_t m = 0; m < motion_.fit.markers.size(); ++m) {
      double squares = 0, seen = 0;
      for (double error : motion_.fit.errors.col(Eigen::Index(m)))
        if (std::isfinite(error)) squares += error * error, ++seen;
      const Vector3d shift = draw.vector() * std::sqrt(seen > 0 ? squares / seen / 3 : 0);
      for (Marker& marker : scene.markers)
        if (marker.name == motion_.fit.markers[m]) marker.at.point += shift;
    }
    return fitted(scene);
  }

  Result<Rows> fitted(const Scene& scene) const {
    auto fit = fit_placed(scene, motion_.markers);
    if (!fit) return tl::unexpected(fit.error());
    return efforts_at(scene, {fit->times, fit->q});
  }

  Result<Rows> efforts_at(const Scene& scene, const RecordedPositions& positions) const {
    const auto system = compile(scene);
    if (!system) return tl::unexpected(system.error());
    MotionEffortsRequest asked;
    asked.cutoff = request_.cutoff;
    auto efforts = efforts_of(*system, positions, motion_.loads, asked);
    if (!efforts) return tl::unexpected(efforts.error());
    if (efforts->efforts.rows() != motion_.efforts.efforts.rows() ||
        efforts->efforts.cols() != motion_.efforts.efforts.cols())
      return failure("joint moments", "the draws differ in coordinates or times; please report this");
    return std::move(efforts->efforts);
  }

  const CapturedMotion& motion_;
  const BodySource& source_;
  const EffortBandRequest& request_;
  PartInertials present_;
  std::vector<std::string> segments_;
  SkeletonOptions options_;
};

}  // namespace

Result<EffortBands> effort_bands(const CapturedMotion& motion, const BodySource& source,
                                 const EffortBandRequest& request) {
  if (source.table.causes.empty())
    return bad_use("joint moments",
                   "have no error bands, because the inertia table has no standard deviations");
  EffortBands out;
  out.causes = {"masses"};
  if (!motion.fit.markers.empty()) out.causes.insert(out.causes.end(), {"joint centres", "markers"});
  const Redrawn redrawn(motion, source, request);
  const int samples = std::max(2, request.samples), all = samples * int(out.causes.size());
  std::vector<std::optional<Rows>> draws(static_cast<std::size_t>(all));
  std::mutex mutex;
  int done = 0;
  in_turns(all, request.threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t n = first; n < last; ++n) {
      auto efforts = redrawn.efforts(int(n) / samples, int(n) % samples);
      if (efforts) draws[std::size_t(n)] = std::move(*efforts);
      const std::lock_guard lock(mutex);
      if (request.progress) request.progress(double(++done) / all);
    }
  });
  const Rows& usual = motion.efforts.efforts;
  Rows variance = Rows::Zero(usual.rows(), usual.cols());
  for (std::size_t cause = 0; cause < out.causes.size(); ++cause) {
    Rows squares = Rows::Zero(usual.rows(), usual.cols());
    int count = 0;
    for (int n = 0; n < samples; ++n)
      if (const auto& efforts = draws[cause * std::size_t(samples) + std::size_t(n)]) {
        squares += (*efforts - usual).cwiseAbs2();
        ++count;
      }
    out.failed += samples - count;
    if (count > 0) squares /= count;
    variance += squares;
    out.by_cause.push_back(squares.cwiseSqrt());
  }
  if (4 * out.failed > all)
    return failure("joint moments", fmt::format("{} of {} draws of the bands failed", out.failed, all));
  out.deviation = variance.cwiseSqrt();
  return out;
}

}  // namespace borelli
