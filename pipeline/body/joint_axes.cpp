#include "pipeline/body/joint_axes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numbers>

#include "pipeline/body/joint_ranges.hpp"
#include "segmentation/vocabulary/part_words.hpp"

namespace borelli {

JointAxes joint_axes(std::string_view joint) {
  const bool left = joint.ends_with("_left"), right = joint.ends_with("_right");
  const std::string kind(joint.substr(0, joint.size() - (left ? 5 : right ? 6 : 0)));
  // With Z to the right, X forwards and Y up, positive rotations do this. About +Z: what points down moves
  // forwards, what points forwards moves up, what points up moves backwards. About +X: what points down moves
  // left, what points up moves right. About +Y: what points forwards moves left.
  Eigen::Matrix3d R_FA;
  if (right)
    R_FA << Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY();
  else if (left)
    R_FA << Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitY();
  else
    R_FA << -Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY();

  JointAxes out{R_FA, {}};
  const std::array<std::vector<std::string>, 3> motions{
      {{"flexion"}, {"adduction", "bending", "deviation", "inversion"}, {"rotation", "pronation"}}};
  for (std::size_t i = 0; i < motions.size(); ++i) {
    out.axes[i] = {"", {-std::numbers::pi, std::numbers::pi}};
    for (const std::string& motion : motions[i])
      if (const auto it = joint_ranges().find(kind + " " + motion); it != joint_ranges().end())
        out.axes[i] = {motion, it->second};
  }
  return out;
}

Warning outside_range(std::string_view joint, std::string_view motion, double angle, const Range& usual) {
  constexpr double degree = std::numbers::pi / 180;
  return joined_warning(
      WarningKind::range, Severity::note,
      "in the scan these joints lie outside their usual ranges, which were widened accordingly",
      fmt::format("{} {} {:.1f} degrees ({:.0f} to {:.0f})", in_words(joint), motion, angle / degree,
                  usual.lower / degree, usual.upper / degree));
}

std::array<Range, 3> ranges_with_start(const JointAxes& joint, const Eigen::Vector3d& start,
                                       std::string_view name, std::vector<Warning>& warnings,
                                       const Eigen::Vector3d& deviation) {
  std::array<Range, 3> out;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto& [motion, range] = joint.axes[i];
    const double x = start[static_cast<Eigen::Index>(i)];
    out[i] = range;
    if (range.holds(x)) continue;
    out[i] = {std::min(range.lower, x), std::max(range.upper, x)};
    const double room = std::max(usual_range_room, deviation[static_cast<Eigen::Index>(i)]);
    if (range.lower - x <= room && x - range.upper <= room) continue;
    warnings.push_back(outside_range(name, motion, x, range));
  }
  return out;
}

}  // namespace borelli
