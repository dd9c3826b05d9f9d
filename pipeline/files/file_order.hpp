// The order of coordinates that a scene's file has, for answers in JSON: its solids one after the other, each
// joint's switches in turn. A compiled system has another order where a solid stands before its parent.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

/// Entry i of a list in the file's order is entry q[i] (positions) or v[i] (velocities) of the system's.
struct FileOrder {
  std::vector<CoordinateInfo> coordinates;  ///< in the file's order; their indices count in the file's lists
  std::vector<Eigen::Index> q, v;
};

/// `coordinates`: a system's or trajectory's free ones, of that scene.
FileOrder file_order(const Scene& scene, const std::vector<CoordinateInfo>& coordinates);

/// The system's `values`, put in the file's order.
std::vector<double> in_file_order(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& order);

}  // namespace borelli
