#include "pipeline/motion/scene_markers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "error/printable.hpp"
#include "pipeline/motion/solid_poses.hpp"

namespace borelli {

using Eigen::Matrix3Xd;
using Eigen::VectorXd;

namespace {

/// Calls visit(column, marker, X_WS) for each named marker, with the pose of its solid.
template <class Scenery, class Visit>
Result<void> for_each_marker(Scenery& scene, const std::vector<std::string>& names, const VectorXd& q,
                             const Visit& visit) {
  const auto system = compile(scene);
  if (!system) return tl::unexpected(system.error());
  SolidPoses poses(*system);
  poses.update(0, q);
  for (std::size_t m = 0; m < names.size(); ++m) {
    const auto marker = std::find_if(scene.markers.begin(), scene.markers.end(),
                                     [&](const Marker& one) { return one.name == names[m]; });
    if (marker == scene.markers.end())
      return bad_use(fmt::format("marker '{}'", printable(names[m])), "the model has no marker of this name");
    visit(Eigen::Index(m), *marker, poses.of(solid_index(*system, marker->at.solid)));
  }
  return {};
}

}  // namespace

Result<Matrix3Xd> marker_places(const Scene& scene, const std::vector<std::string>& names,
                                const VectorXd& q) {
  Matrix3Xd out(3, Eigen::Index(names.size()));
  const auto done = for_each_marker(
      scene, names, q,
      [&](Eigen::Index m, const Marker& marker, const Pose& X_WS) { out.col(m) = X_WS * marker.at.point; });
  if (!done) return tl::unexpected(done.error());
  return out;
}

Result<void> move_markers(Scene& scene, const std::vector<std::string>& names, const Matrix3Xd& places,
                          const VectorXd& q) {
  return for_each_marker(scene, names, q, [&](Eigen::Index m, Marker& marker, const Pose& X_WS) {
    marker.at.point = X_WS.inverse() * places.col(m);
  });
}

void start_at(Scene& scene, const System& system, const VectorXd& q) {
  for (Solid& solid : scene.solids)
    for (std::size_t i = 0; i < solid.switches.size(); ++i)
      for (const CoordinateInfo& c : system.coordinates)
        if (const Motion& motion = solid.switches[i].motion; c.name == coordinate_name(solid, i) &&
                                                             !std::holds_alternative<Locked>(motion) &&
                                                             !std::holds_alternative<Coupled>(motion))
          solid.switches[i].q = {q.data() + c.q_index, q.data() + c.q_index + c.q_size};
}

}  // namespace borelli
