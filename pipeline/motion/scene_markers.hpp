// The markers of a scene at given positions of its coordinates.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/system.hpp"
#include "error/error.hpp"

namespace borelli {

/// World places, m, of named markers of the scene at positions q (nq of its system). Errors: as compile.
Result<Eigen::Matrix3Xd> marker_places(const Scene& scene, const std::vector<std::string>& names,
                                       const Eigen::VectorXd& q);

/// Puts the named markers, in their solids, where `places` (3 x #names; m, world) has them at positions q.
Result<void> move_markers(Scene& scene, const std::vector<std::string>& names, const Eigen::Matrix3Xd& places,
                          const Eigen::VectorXd& q);

/// Lets the free coordinates of the scene start at q.
void start_at(Scene& scene, const System& system, const Eigen::VectorXd& q);

}  // namespace borelli
