// The order of coordinates in a scene's file, for JSON answers: solid by solid, and each joint's switches in
// turn. A compiled system has another order if a solid stands before its parent.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

/// Entry i of a list in the file's order is the system's entry q[i] (positions) or v[i] (velocities).
struct FileOrder {
  std::vector<CoordinateInfo> coordinates;  ///< in the file's order, with indices into the file's lists
  std::vector<Eigen::Index> q, v;
};

/// `coordinates`: free coordinates of a system or trajectory of that scene.
FileOrder file_order(const Scene& scene, const std::vector<CoordinateInfo>& coordinates);

/// Sorts the system's `values` into the file's order.
std::vector<double> in_file_order(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& order);

}  // namespace borelli
