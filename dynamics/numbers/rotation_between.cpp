#include "dynamics/numbers/rotation_between.hpp"

#include <Eigen/Geometry>

namespace borelli {

Eigen::Matrix3d rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

}  // namespace borelli
