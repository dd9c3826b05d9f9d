// The smallest rotation between two directions. It stands in a file of its own: Eigen's template behind it takes a
// compiler several seconds in each file that uses it.
#pragma once

#include <Eigen/Core>

namespace borelli {

/// R with R from/|from| = to/|to| and the smallest angle. Opposite directions: half a turn about one of the axes
/// across both.
Eigen::Matrix3d rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace borelli
