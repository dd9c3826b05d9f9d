// A force and its moment.
#pragma once

#include <Eigen/Core>

namespace borelli {

/// A force (N) and its moment (N m) about the origin of the frame that it acts on; world axes.
template <class T>
struct Wrench {
  Eigen::Vector3<T> n = Eigen::Vector3<T>::Zero();  ///< moment
  Eigen::Vector3<T> f = Eigen::Vector3<T>::Zero();  ///< force
};

}  // namespace borelli
