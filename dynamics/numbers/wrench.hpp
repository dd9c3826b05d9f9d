// A force and its moment.
#pragma once

#include <Eigen/Core>

namespace borelli {

/// A force and its moment about the origin of the frame that it acts on; world axes, N, N m.
template <class T>
struct Wrench {
  Eigen::Vector3<T> n = Eigen::Vector3<T>::Zero();  ///< moment
  Eigen::Vector3<T> f = Eigen::Vector3<T>::Zero();  ///< force
};

}  // namespace borelli
