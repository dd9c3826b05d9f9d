#include "pipeline/motion/foot_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "error/printable.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

constexpr double farthest_foot = 0.5;  // m, from the centre of pressure
constexpr double alike = 0.1;          // m, distances too near to each other to tell the feet apart
constexpr double shortest = 0.05;      // s, of a stance; shorter loads are noise of a plate

/// A stance on a plate: samples from first to last.
struct PlateStance {
  Eigen::Index first = 0, last = 0;
};

std::vector<PlateStance> stances_on(const MeasuredForce& plate) {
  std::vector<PlateStance> out;
  bool loaded = false;
  for (Eigen::Index i = 0; i < plate.force.cols(); ++i) {
    const bool now = plate.force.col(i).norm() >= least_load && plate.point.col(i).allFinite();
    if (now && !loaded) out.push_back({i, i});
    if (now) out.back().last = i;
    loaded = now;
  }
  std::erase_if(out, [&](const PlateStance& stance) {
    return plate.times[std::size_t(stance.last)] - plate.times[std::size_t(stance.first)] < shortest;
  });
  return out;
}

/// Mean distance of each foot from the centre of pressure over a stance, at some fifty of its samples.
class FootDistances {
 public:
  FootDistances(const System& system, const RecordedMotion& motion, std::vector<int> feet)
      : motion_(motion), feet_(std::move(feet)), poses_(system) {}

  std::vector<double> over(const MeasuredForce& plate, const PlateStance& stance) {
    std::vector<double> sums(feet_.size(), 0);
    const Eigen::Index stride = std::max<Eigen::Index>(1, (stance.last - stance.first) / 50);
    int count = 0;
    for (Eigen::Index i = stance.first; i <= stance.last; i += stride) {
      const double t = plate.times[std::size_t(i)];
      if (t < motion_.start() || t > motion_.end()) continue;
      motion_.at(t, state_, a_);
      poses_.update(t, state_.q);
      for (std::size_t f = 0; f < feet_.size(); ++f)
        sums[f] += (poses_.of(feet_[f]).p - plate.point.col(i)).norm();
      ++count;
    }
    for (double& sum : sums) sum = count > 0 ? sum / count : std::numeric_limits<double>::infinity();
    return sums;
  }

 private:
  const RecordedMotion& motion_;
  std::vector<int> feet_;
  SolidPoses poses_;
  State state_;
  Eigen::VectorXd a_;
};

}  // namespace

std::vector<std::string> feet_of(const System& system) {
  for (const std::vector<const char*>& parts : {std::vector{"calcn", "calcaneus"}, std::vector{"foot"}}) {
    std::vector<std::string> out;
    for (const std::string& solid : system.solids)
      if (std::any_of(parts.begin(), parts.end(),
                      [&](const char* part) { return lower_case(solid).find(part) != std::string::npos; }))
        out.push_back(solid);
    if (!out.empty()) return out;
  }
  return {};
}

Result<FootLoads> loads_on_feet(const System& system, const RecordedMotion& motion,
                                const std::vector<MeasuredForce>& forces,
                                const std::vector<std::string>& feet) {
  if (feet.empty())
    return bad_use("measured forces",
                   "no solid of the model has calcn, calcaneus or foot in its name; give the forces as "
                   "OpenSim's external "
                   "loads (.xml), which name the solids");
  std::vector<int> solids;
  for (const std::string& foot : feet) {
    solids.push_back(solid_index(system, foot));
    if (solids.back() < 0)
      return bad_use(fmt::format("foot '{}'", printable(foot)), "the model has no solid of this name");
  }
  FootDistances distances(system, motion, solids);
  FootLoads out;
  for (const MeasuredForce& plate : forces) {
    std::vector<ExternalLoad> by_foot;
    for (const std::string& foot : feet) {
      const Eigen::Index n = plate.force.cols();
      by_foot.push_back(
          {foot,
           "ground",
           "ground",
           {fmt::format("{} on {}", foot, plate.name), plate.times, Matrix3Xd::Zero(3, n),
            Matrix3Xd::Constant(3, n, std::numeric_limits<double>::quiet_NaN()), Matrix3Xd::Zero(3, n)}});
    }
    std::vector<char> used(feet.size(), false);
    for (const PlateStance& stance : stances_on(plate)) {
      const std::vector<double> away = distances.over(plate, stance);
      const auto nearest = std::size_t(std::min_element(away.begin(), away.end()) - away.begin());
      const double from = plate.times[std::size_t(stance.first)], to = plate.times[std::size_t(stance.last)];
      if (std::isinf(away[nearest])) continue;  // outside of the motion
      if (away[nearest] > farthest_foot) {
        out.warnings.push_back(fmt::format(
            "the load on {} from {:.2f} to {:.2f} s was left out: it is {:.2f} m from the nearest foot",
            printable(plate.name), from, to, away[nearest]));
        continue;
      }
      for (std::size_t f = 0; f < feet.size(); ++f)
        if (f != nearest && away[f] - away[nearest] < alike)
          out.warnings.push_back(
              fmt::format("the load on {} from {:.2f} to {:.2f} s was given to {}, but {} is about as near",
                          printable(plate.name), from, to, feet[nearest], feet[f]));
      const Eigen::Index n = stance.last - stance.first + 1;
      MeasuredForce& target = by_foot[nearest].measured;
      target.force.middleCols(stance.first, n) = plate.force.middleCols(stance.first, n);
      target.point.middleCols(stance.first, n) = plate.point.middleCols(stance.first, n);
      target.moment.middleCols(stance.first, n) = plate.moment.middleCols(stance.first, n);
      used[nearest] = true;
    }
    for (std::size_t f = 0; f < feet.size(); ++f)
      if (used[f]) out.loads.push_back(std::move(by_foot[f]));
  }
  return out;
}

}  // namespace borelli
