// The smallest rotation between two directions. It has a file of its own, since Eigen's template for it takes
// several seconds to compile in each file that uses it.
#pragma once

#include <Eigen/Core>

namespace borelli {

/// R with R from/|from| = to/|to| and the smallest angle. Opposite directions: half a turn about one of the axes
/// across both.
Eigen::Matrix3d rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace borelli
