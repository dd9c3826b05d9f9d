#include "pipeline/motion/walk_markers.hpp"

#include <algorithm>
#include <vector>

#include "pipeline/motion/body_markers.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {
namespace {

std::vector<std::string> walk_marker_names() {
  std::vector<std::string> names{"CLAV", "C7", "STRN", "Top.Head"};
  for (const char* side : {"R.", "L."})
    for (const char* name : {"ASIS", "PSIS", "Knee.Lat", "Knee.Med", "Ankle.Lat", "Ankle.Med", "Heel",
                             "Toe.Tip", "MT1", "MT5", "Elbow.Lat", "Elbow.Med", "RSP", "USP", "Hand"})
      names.push_back(std::string(side) + name);
  return names;
}

/// A marker in front of the middle of a bone, on the skin.
struct FrontMarker {
  const char *name, *solid, *upper, *lower;
  double front;  ///< m
};
constexpr FrontMarker front_markers[]{{"Thigh.Front", "thigh_", "hip_", "knee_", 0.06},
                                      {"Shank.Front", "shank_", "knee_", "ankle_", 0.05}};

}  // namespace

Result<std::map<std::string, SolidPoint>> walk_markers(const Scene& body, const Landmarks& landmarks) {
  const auto system = compile(body);
  if (!system) return tl::unexpected(system.error());
  SolidPoses poses(*system);
  poses.update(0, system->initial.q);
  std::map<std::string, SolidPoint> out;
  const auto add = [&](const std::string& name, const std::string& solid, const Eigen::Vector3d& p_W) {
    if (const int index = solid_index(*system, solid); index >= 0)
      out[name] = {solid, poses.of(index).inverse() * p_W};
  };
  for (const BodyMarker& marker :
       body_markers(walk_marker_names(), landmarks, system->solids, PointKind::markers).markers)
    if (marker.point) add(marker.name, marker.segment, *marker.point);
  for (const bool left : {false, true})
    for (const FrontMarker& marker : front_markers) {
      const std::string side = left ? "left" : "right";
      const auto upper = landmarks.find(marker.upper + side), lower = landmarks.find(marker.lower + side);
      if (upper == landmarks.end() || lower == landmarks.end()) continue;
      const Eigen::Vector3d middle = 0.5e-3 * (upper->second.point + lower->second.point);
      add((left ? "L." : "R.") + std::string(marker.name), marker.solid + side,
          middle - marker.front * Eigen::Vector3d::UnitY());
    }
  return out;
}

FootSoles standing_soles(const Landmarks& landmarks) {
  FootSoles soles;
  for (const std::string side : {"left", "right"})
    for (const char* stem : {"heel_", "metatarsal_1_", "metatarsal_5_", "toe_tip_"})
      if (const auto found = landmarks.find(stem + side); found != landmarks.end()) {
        const Eigen::Vector3d p = 1e-3 * found->second.point;
        soles["foot_" + side].emplace_back(p.x(), p.y(), 0);
      }
  return soles;
}

}  // namespace borelli
