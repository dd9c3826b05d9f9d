#include "pipeline/motion/marker_calibration.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/motion/marker_placement.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_frames = 64;
constexpr int most_rounds = 150;
constexpr double still = 2e-5;  // m

/// Frames spread evenly over a motion.
MarkerMotion thinned(const MarkerMotion& motion) {
  MarkerMotion out{motion.names, {}, {}, motion.up};
  const std::size_t count = motion.times.size(), kept = std::min(count, most_frames);
  for (std::size_t k = 0; k < kept; ++k) {
    const std::size_t f = kept > 1 ? k * (count - 1) / (kept - 1) : 0;
    out.times.push_back(motion.times[f]);
    out.frames.push_back(motion.frames[f]);
  }
  return out;
}

/// Anderson's acceleration of a fixed-point iteration x = g(x): the combination of the last results whose
/// changes g - x cancel best (Walker and Ni (2011) SIAM J Numer Anal 49:1715).
class Acceleration {
 public:
  VectorXd next(const VectorXd& x, const VectorXd& g) {
    const VectorXd change = g - x;
    VectorXd out = g;
    if (change_.size() > 0) {
      if (std::ssize(results_) == depth) results_.erase(results_.begin()), changes_.erase(changes_.begin());
      results_.push_back(g - result_);
      changes_.push_back(change - change_);
      Eigen::MatrixXd D(change.size(), std::ssize(changes_)), G(D.rows(), D.cols());
      for (Eigen::Index k = 0; k < D.cols(); ++k)
        D.col(k) = changes_[std::size_t(k)], G.col(k) = results_[std::size_t(k)];
      out -= G * D.colPivHouseholderQr().solve(change);
    }
    result_ = g;
    change_ = change;
    return out;
  }
  void forget() { results_.clear(), changes_.clear(), change_.resize(0); }

 private:
  static constexpr std::ptrdiff_t depth = 6;
  std::vector<VectorXd> results_, changes_;  ///< differences from round to round
  VectorXd result_, change_;
};

VectorXd places_of(const Scene& scene) {
  VectorXd out(3 * std::ssize(scene.markers));
  for (std::size_t m = 0; m < scene.markers.size(); ++m)
    out.segment<3>(3 * Eigen::Index(m)) = scene.markers[m].at.point;
  return out;
}

void place(Scene& scene, const VectorXd& places) {
  for (std::size_t m = 0; m < scene.markers.size(); ++m)
    scene.markers[m].at.point = places.segment<3>(3 * Eigen::Index(m));
}

/// The mean of each marker's measured places in its solid; of one that was not seen, its place in the scene.
VectorXd mean_places(const Scene& scene, const System& system, const MarkerMotion& motion,
                     const MotionFit& fit) {
  std::vector<std::size_t> frames;  // of each fitted time
  for (std::size_t f = 0; frames.size() < fit.times.size(); ++f)
    if (std::abs(motion.times[f] - fit.times[frames.size()]) < 1e-9) frames.push_back(f);
  SolidPoses poses(system);
  std::vector<Vector3d> sums(scene.markers.size(), Vector3d::Zero());
  std::vector<double> counts(scene.markers.size(), 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    poses.update(0, fit.q.row(Eigen::Index(i)).transpose());
    for (std::size_t m = 0; m < scene.markers.size(); ++m) {
      const Marker& marker = scene.markers[m];
      const auto column = std::ranges::find(motion.names, marker.name) - motion.names.begin();
      if (column == std::ssize(motion.names)) continue;
      const Vector3d measured = motion.frames[frames[i]].col(column);
      if (!measured.allFinite()) continue;
      sums[m] += poses.of(solid_index(system, marker.at.solid)).inverse() * measured;
      ++counts[m];
    }
  }
  VectorXd out = places_of(scene);
  for (std::size_t m = 0; m < scene.markers.size(); ++m)
    if (counts[m] > 0) out.segment<3>(3 * Eigen::Index(m)) = sums[m] / counts[m];
  return out;
}

}  // namespace

Result<CalibratedMarkers> calibrated_markers(const Scene& scene, const MarkerMotion& motion) {
  CalibratedMarkers out{scene};
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  const MarkerMotion used = thinned(motion);
  Acceleration acceleration;
  Scene tried = scene;
  double least = std::numeric_limits<double>::infinity();
  VectorXd means;  // of the best places so far
  for (int round = 0;; ++round) {
    const auto fit = fit_placed(tried, used);
    if (!fit) return tl::unexpected(fit.error());
    const double rms = fit->rms();
    if (round == 0) out.rms_before = rms;
    const bool better = rms < least;
    if (better) {
      least = out.rms_after = rms;
      out.scene = tried;
      means = mean_places(tried, *system, used, *fit);
      if ((means - places_of(tried)).cwiseAbs().maxCoeff() < still) return out;
    }
    if (round == most_rounds) return out;
    // the plain step never raises the error; an accelerated one may
    if (!better) acceleration.forget();
    place(tried, better ? acceleration.next(places_of(tried), means) : means);
  }
}

}  // namespace borelli
