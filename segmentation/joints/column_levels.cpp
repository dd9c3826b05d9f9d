#include "segmentation/joints/column_levels.hpp"

#include <array>
#include <string>

#include "segmentation/joints/vertebrae.hpp"

namespace borelli {

using Eigen::Vector3d;

void find_column_levels(const Anatomy& a, const Trunk& trunk, Landmarks& landmarks) {
  const auto neck = landmarks.find("neck"), left = landmarks.find("hip_left"),
             right = landmarks.find("hip_right");
  if (neck == landmarks.end() || left == landmarks.end() || right == landmarks.end()) return;
  const double bottom = 0.5 * (left->second.point[2] + right->second.point[2]);
  const double height = neck->second.point[2] - bottom;
  constexpr std::array<std::pair<const char*, double>, 3> levels{
      {{"t12_l1", 0.485}, {"l4_l5", 0.27}, {"l5_s1", 0.212}}};
  constexpr double deviation = 15;  // mm
  for (const auto& [name, share] : levels) {
    const double z = bottom + share * height;
    if (landmarks.contains(name) || !trunk.spine_holds(z)) continue;
    landmarks[name] = {vertebral_body(a, trunk, z), deviation, 0, "proportion: between hips and neck"};
  }
}

void seat_spine_joints(Convention convention, Landmarks& landmarks) {
  if (convention == Convention::deleva1996) return;
  for (const char* joint : {"spine_upper", "spine_lower"}) {
    const auto disc = landmarks.find(bound_of(joint, convention));
    if (disc != landmarks.end())
      landmarks[joint] = disc->second;
    else
      landmarks.erase(joint);
  }
}

}  // namespace borelli
