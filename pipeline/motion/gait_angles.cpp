#include "pipeline/motion/gait_angles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace borelli {
namespace {

// degrees, every 5 % of the cycle from heel strike
constexpr int instants = 20;
constexpr std::array<double, instants> hip_deg{20,  20,  19,  16, 11, 6,  0,  -5, -11, -16,
                                               -20, -18, -12, -3, 7,  15, 21, 25, 25,  22};
constexpr std::array<double, instants> knee_deg{5,  10, 15, 16, 13, 9,  6,  5,  5,  7,
                                                10, 21, 35, 50, 59, 60, 50, 32, 14, 5};
constexpr std::array<double, instants> ankle_deg{0, -4, -4,  -1,  1,   3,  5,  7, 9, 10,
                                                 9, 1,  -11, -15, -11, -5, -1, 0, 0, 0};
constexpr int angle_harmonics = 7;

PeriodicSeries sketched_angles() {
  Eigen::MatrixXd samples(instants, 3);
  for (int i = 0; i < instants; ++i) {
    const auto k = std::size_t(i);
    samples.row(i) << hip_deg[k], knee_deg[k], ankle_deg[k];
  }
  return {samples * (std::numbers::pi / 180), angle_harmonics};
}

}  // namespace

LegAngles leg_angles(double phase) {
  static const PeriodicSeries series = sketched_angles();
  const Eigen::VectorXd angles = series.at(phase);
  return {angles[0], angles[1], angles[2]};
}

double smooth_step(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 + x * (6 * x - 15));
}

PeriodicSeries::PeriodicSeries(const Eigen::MatrixXd& samples, int harmonics)
    : cosines(Eigen::MatrixXd::Zero(harmonics + 1, samples.cols())),
      sines(Eigen::MatrixXd::Zero(harmonics + 1, samples.cols())) {
  const Eigen::Index count = samples.rows();
  for (Eigen::Index k = 0; k <= harmonics; ++k)
    for (Eigen::Index i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * double(k * i) / double(count);
      const double weight = (k == 0 ? 1.0 : 2.0) / double(count);
      cosines.row(k) += weight * std::cos(angle) * samples.row(i);
      sines.row(k) += weight * std::sin(angle) * samples.row(i);
    }
}

Eigen::VectorXd PeriodicSeries::at(double phase) const {
  Eigen::VectorXd out = cosines.row(0).transpose();
  for (Eigen::Index k = 1; k < cosines.rows(); ++k) {
    const double angle = 2 * std::numbers::pi * double(k) * phase;
    out += std::cos(angle) * cosines.row(k).transpose() + std::sin(angle) * sines.row(k).transpose();
  }
  return out;
}

}  // namespace borelli
