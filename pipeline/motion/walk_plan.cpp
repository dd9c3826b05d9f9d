#include "pipeline/motion/walk_plan.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/motion/gait_angles.hpp"

namespace borelli {

using Eigen::Vector3d;

namespace {

// shares of the cycle
constexpr double double_support = stance_share - 0.5;
constexpr double flat_from = 0.12, flat_to = 0.33;       // the foot lies flat
constexpr double landing_from = 0, heel_free_at = 0.45;  // outside of them its pitch is the published one
constexpr double roll_from = 0, roll_to = 0.25;          // the centre of pressure goes forwards
constexpr double swing_delay = 1.3;                      // > 1: the foot is fastest late in the swing
constexpr double swing_height = 0.11;                    // m, of the leading point

/// Phase within the cycle, and how many have passed.
struct Phase {
  double share = 0, whole = 0;
};

Phase phase_of(const WalkingFoot& foot, double cycles) {
  const double own = cycles - foot.lead;
  return {own - std::floor(own), std::floor(own)};
}

double planned_pitch(double phase) {
  const double part = phase < flat_from ? 1 - smooth_step((phase - landing_from) / (flat_from - landing_from))
                                        : smooth_step((phase - flat_to) / (heel_free_at - flat_to));
  return part * leg_angles(phase).foot_pitch();
}

/// Where the flat foot of a step has a point of its sole.
Vector3d standing_point(const WalkingFoot& foot, const WalkTiming& timing, double whole,
                        const Vector3d& p_S) {
  const Vector3d arm = foot.X_WS.R * (p_S - foot.heel), heel = foot.X_WS * foot.heel;
  return {heel.x() + foot.inward + arm.x(), arm.y() - timing.stride() * (whole + foot.lead), 0};
}

}  // namespace

Result<std::array<WalkingFoot, 2>> walking_feet(const std::map<std::string, Pose, std::less<>>& poses,
                                                const FootSoles& soles, double width) {
  std::array<WalkingFoot, 2> feet;
  for (std::size_t f = 0; f < 2; ++f) {
    WalkingFoot& foot = feet[f];
    foot.solid = f == 0 ? "foot_right" : "foot_left";
    foot.lead = f == 0 ? 0 : 0.5;
    const auto sole = soles.find(foot.solid);
    const auto pose = poses.find(foot.solid);
    if (sole == soles.end() || pose == poses.end() || sole->second.size() < 3)
      return bad_use("sample walk", fmt::format("needs three points of the sole of {}", foot.solid));
    std::vector<Vector3d> points = sole->second;
    std::ranges::sort(points, {}, [](const Vector3d& p) { return -p.y(); });  // from behind
    foot.X_WS = pose->second;
    foot.heel = foot.X_WS.inverse() * points[0];
    foot.front = foot.X_WS.inverse() * points[points.size() - (points.size() > 3 ? 2 : 1)];
    foot.inward = (f == 0 ? -width : width) / 2 - points[0].x();
  }
  return feet;
}

Pose planned_foot(const WalkingFoot& foot, const WalkTiming& timing, double cycles) {
  const Phase phase = phase_of(foot, cycles);
  const double pitch = planned_pitch(phase.share);
  const double swing = std::clamp((phase.share - stance_share) / (1 - stance_share), 0.0, 1.0);
  const Vector3d front = standing_point(foot, timing, phase.whole, foot.front);
  Vector3d leader_S = pitch >= 0 ? foot.heel : foot.front;
  Vector3d leader = standing_point(foot, timing, phase.whole, leader_S);
  if (swing > 0) {
    const double done = smooth_step(std::pow(swing, swing_delay));
    leader_S = foot.front + done * (foot.heel - foot.front);
    const Vector3d next = standing_point(foot, timing, phase.whole + 1, foot.heel);
    leader = front + done * (next - front);
    constexpr double top = 27. * 256 / 823543;  // of s^3 (1 - s)^4, at s = 3/7
    leader.z() = swing_height * std::pow(swing, 3) * std::pow(1 - swing, 4) / top;
  }
  Pose X = foot.X_WS;
  X.R = Eigen::AngleAxisd(-pitch, Vector3d::UnitX()).toRotationMatrix() * foot.X_WS.R;
  X.p = leader - X.R * leader_S;
  return X;
}

double planned_share(const WalkingFoot& foot, double cycles) {
  const double phase = phase_of(foot, cycles).share;
  return smooth_step(phase / double_support) - smooth_step((phase - 0.5) / double_support);
}

Vector3d planned_pressure(const WalkingFoot& foot, const WalkTiming& timing, double cycles) {
  const Phase phase = phase_of(foot, cycles);
  const double rolled = smooth_step((phase.share - roll_from) / (roll_to - roll_from));
  return standing_point(foot, timing, phase.whole, foot.heel + rolled * (foot.front - foot.heel));
}

}  // namespace borelli
