#include "pipeline/motion/marker_paths.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "error/printable.hpp"

namespace borelli {

Result<MarkerMotion> marker_paths(const Scene& scene, const Trajectory& motion) {
  if (scene.markers.empty())
    return bad_use("markers", "are not in the scene, so their paths cannot be written");
  MarkerMotion out;
  out.times = motion.times;
  std::vector<std::size_t> solids;
  for (const Marker& marker : scene.markers) {
    const auto solid = std::ranges::find(motion.solids, marker.at.solid);
    if (solid == motion.solids.end())
      return bad_use(fmt::format("marker '{}'", printable(marker.name)),
                     fmt::format("is on '{}', which the motion does not have", printable(marker.at.solid)));
    out.names.push_back(marker.name);
    solids.push_back(std::size_t(solid - motion.solids.begin()));
  }
  for (std::size_t i = 0; i < motion.times.size(); ++i) {
    Eigen::Matrix3Xd places(3, std::ssize(solids));
    for (std::size_t m = 0; m < solids.size(); ++m)
      places.col(Eigen::Index(m)) = motion.pose(i, solids[m]) * scene.markers[m].at.point;
    out.frames.push_back(std::move(places));
  }
  return out;
}

}  // namespace borelli
