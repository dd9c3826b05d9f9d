#include "pipeline/motion/static_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "error/printable.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/motion/scaled_scene.hpp"
#include "pipeline/motion/scene_markers.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double least_marker_spread = 0.01;  // m
constexpr double factor_spread = 0.1;

/// Least squares in the factors at one pose, with the whole body's factor as one more unknown.
class FactorSolve {
 public:
  FactorSolve(const Scene& scene, const std::vector<std::string>& markers, bool per_segment)
      : scene_(scene), markers_(markers), per_segment_(per_segment) {}

  Result<VectorXd> solve(const Matrix3Xd& measured, const VectorXd& q, double marker_spread) const {
    const auto n = Eigen::Index(scene_.solids.size());
    const Eigen::Index unknowns = per_segment_ ? n : 1;
    const VectorXd ones = VectorXd::Ones(n);
    const auto base = places(ones, q);
    if (!base) return tl::unexpected(base.error());
    MatrixXd J(measured.size(), unknowns);
    for (Eigen::Index b = 0; b < unknowns; ++b) {
      // a marker's place is linear in the factors: twice the size shows the slope
      const auto larger =
          places(per_segment_ ? VectorXd(ones + VectorXd::Unit(n, b)) : VectorXd(2 * ones), q);
      if (!larger) return tl::unexpected(larger.error());
      const Matrix3Xd slope = *larger - *base;
      J.col(b) = slope.reshaped();
    }
    const Matrix3Xd at_zero = *base;
    VectorXd wanted = (measured - at_zero).reshaped();
    wanted += J * VectorXd::Ones(unknowns);  // at_zero + J (s - 1) = measured
    MatrixXd H = J.transpose() * J / (marker_spread * marker_spread);
    VectorXd right = J.transpose() * wanted / (marker_spread * marker_spread);
    if (!per_segment_) return VectorXd(ones * (right[0] / H(0, 0)));
    // unknown g: its best value is the mean of the factors, so that the prior is their spread about the mean
    const MatrixXd centring = MatrixXd::Identity(n, n) - MatrixXd::Constant(n, n, 1.0 / double(n));
    H += centring / (factor_spread * factor_spread);
    return VectorXd(H.ldlt().solve(right));
  }

 private:
  Result<Matrix3Xd> places(const VectorXd& factors, const VectorXd& q) const {
    return marker_places(scaled(scene_, {factors.begin(), factors.end()}).scene, markers_, q);
  }

  const Scene& scene_;
  const std::vector<std::string>& markers_;
  bool per_segment_;
};

Result<MotionFit> fit_pose(const Scene& scene, const MarkerMotion& mean, const VectorXd& rest_weights) {
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  MotionFitRequest fit;
  fit.rest_weights = rest_weights;
  return fit_motion(scene, *system, mean, fit);
}

struct MeasuredMarkers {
  std::vector<std::string> names;
  Matrix3Xd places;  // m, in the scene's axes
};

// Those of the markers that the trial shows.
Result<MeasuredMarkers> measured_markers(const Scene& scene, const MarkerMotion& mean,
                                         const std::vector<std::string>& shared) {
  const Eigen::Matrix3d turn = turn_to_scene(scene, mean.up);
  MeasuredMarkers out;
  std::vector<Vector3d> seen;
  for (const std::string& name : shared) {
    const auto column = std::find(mean.names.begin(), mean.names.end(), name) - mean.names.begin();
    if (!mean.frames[0].col(column).allFinite()) continue;
    out.names.push_back(name);
    seen.push_back(turn * mean.frames[0].col(column));
  }
  if (seen.size() < 3)
    return bad_use("static trial",
                   fmt::format("shows {} markers of the model; scaling needs at least 3", seen.size()));
  out.places.resize(3, Eigen::Index(seen.size()));
  for (std::size_t m = 0; m < seen.size(); ++m) out.places.col(Eigen::Index(m)) = seen[m];
  return out;
}

// Sets the factors to `found`; returns the largest change.
Result<double> set_factors(const Scene& scene, const VectorXd& found, std::vector<double>& factors) {
  double change = 0;
  for (std::size_t b = 0; b < factors.size(); ++b) {
    const double s = found[Eigen::Index(b)];
    if (!(s > 0.2 && s < 5))
      return bad_use(
          "static trial",
          fmt::format(
              "would scale '{}' by {:.2f}, expected 0.2 to 5; check the trial's unit and marker names",
              printable(scene.solids[b].name), s));
    change = std::max(change, std::abs(s - factors[b]));
    factors[b] = s;
  }
  return change;
}

// Fits factors and pose in turns, from `pose` of the unscaled scene on. Returns the last pose.
Result<MotionFit> fit_factors(const Scene& scene, const MarkerMotion& mean, const MeasuredMarkers& measured,
                              const StaticFitRequest& request, MotionFit pose, StaticFit& out) {
  const FactorSolve solve(scene, measured.names, request.per_segment);
  constexpr int most_turns = 500;
  int turns = 0;
  for (double change = 1; change > 1e-6 && turns < most_turns; ++turns) {
    VectorXd q = pose.q.row(0).transpose();
    const auto factors = solve.solve(measured.places, q, std::max(least_marker_spread, pose.rms()));
    if (!factors) return tl::unexpected(factors.error());
    const auto changed = set_factors(scene, *factors, out.factors);
    if (!changed) return tl::unexpected(changed.error());
    change = *changed;
    out.scene = scaled(scene, out.factors).scene;
    const auto system = compile(out.scene);
    if (!system) return tl::unexpected(system.error());
    if (request.rest_weights.size() == 0)
      start_at(out.scene, *system, q);  // else the start is where joints rest
    auto next = fit_pose(out.scene, mean, request.rest_weights);
    if (!next) return next;
    pose = std::move(*next);
  }
  if (turns == most_turns) out.warnings.push_back("the scale factors had not converged when the fit ended");
  out.rms_after = pose.rms();
  return pose;
}

void warn_of_odd_factors(StaticFit& fit) {
  double mean = 0;
  for (double s : fit.factors) mean += s / double(fit.factors.size());
  std::vector<std::string> odd;
  for (std::size_t b = 0; b < fit.factors.size(); ++b)
    if (std::abs(fit.factors[b] / mean - 1) > 0.15)
      odd.push_back(fmt::format("{} {:.2f}", printable(fit.scene.solids[b].name), fit.factors[b]));
  if (!odd.empty())
    fit.warnings.push_back(fmt::format(
        "scale factors differ from their mean, {:.2f}, by more than 15 %: {}; the model's proportions or "
        "markers may not fit this person: check the marker errors, or leave out --per-segment",
        mean, name_list(odd)));
}

// Scales the scene by the factors of `fit`, and its masses to `mass` if that is given.
Result<void> scale_to_mass(const Scene& scene, const std::optional<double>& mass, StaticFit& fit) {
  auto whole = scaled(scene, fit.factors);
  const auto by_volume = total_mass(whole.scene);
  if (!by_volume) return tl::unexpected(by_volume.error());
  if (mass) whole = scaled(scene, fit.factors, *mass / *by_volume);
  fit.mass = mass.value_or(*by_volume);
  fit.warnings.insert(fit.warnings.end(), whole.warnings.begin(), whole.warnings.end());
  fit.scene = std::move(whole.scene);
  return {};
}

}  // namespace

MarkerMotion mean_frame(const MarkerMotion& trial, double start, double end) {
  MarkerMotion out{trial.names, {0}, {Matrix3Xd::Zero(3, Eigen::Index(trial.names.size()))}, trial.up};
  for (Eigen::Index m = 0; m < out.frames[0].cols(); ++m) {
    Vector3d sum = Vector3d::Zero();
    int seen = 0;
    for (std::size_t f = 0; f < trial.frames.size(); ++f)
      if (trial.times[f] >= start && trial.times[f] <= end && trial.frames[f].col(m).allFinite()) {
        sum += trial.frames[f].col(m);
        ++seen;
      }
    out.frames[0].col(m) = sum / seen;  // never seen: not a number, a gap
  }
  return out;
}

Result<StaticFit> fit_static(const Scene& scene, const MarkerMotion& trial, const StaticFitRequest& request) {
  const MarkerMotion mean = mean_frame(trial, request.start, request.end);
  auto pose = fit_pose(scene, mean, request.rest_weights);
  if (!pose) return tl::unexpected(pose.error());
  StaticFit out{.scene = scene,
                .factors = std::vector<double>(scene.solids.size(), 1),
                .mass = 0,
                .rms_before = pose->rms(),
                .rms_after = 0,
                .warnings = pose->warnings};
  const auto measured = measured_markers(scene, mean, pose->markers);
  if (!measured) return tl::unexpected(measured.error());
  pose = fit_factors(scene, mean, *measured, request, std::move(*pose), out);
  if (!pose) return tl::unexpected(pose.error());
  const VectorXd q = pose->q.row(0).transpose();
  warn_of_odd_factors(out);
  if (auto done = scale_to_mass(scene, request.mass, out); !done) return tl::unexpected(done.error());
  if (request.move_markers)
    if (auto moved = move_markers(out.scene, measured->names, measured->places, q); !moved)
      return tl::unexpected(moved.error());
  const auto system = compile(out.scene);
  if (!system) return tl::unexpected(system.error());
  start_at(out.scene, *system, q);
  return out;
}

}  // namespace borelli
