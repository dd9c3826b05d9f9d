// A tree of bodies in Simbody, built joint by joint, behind an interface because Simbody's headers are C++17.
// Needs Simbody.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace borelli::test {

/// A frame in a body: a position, then rotations about its own x, y and z in turn (rad).
struct SimbodyFrame {
  Eigen::Vector3d place = Eigen::Vector3d::Zero(), angles = Eigen::Vector3d::Zero();
};

/// Mass, mass centre, and moments about the centre: xx, yy, zz, xy, xz, yz.
struct SimbodyMass {
  double mass = 1;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double inertia[6] = {1, 1, 1, 0, 0, 0};
};

/// An axis of MobilizedBody::FunctionBased, displaced by a function of a joint coordinate.
struct SimbodyAxis {
  Eigen::Vector3d axis;
  int coordinate = -1;                            ///< -1: none
  std::function<double(double x, int order)> by;  ///< value, first or second derivative
};

class SimbodyTree {
 public:
  SimbodyTree();
  SimbodyTree(SimbodyTree&&) noexcept;
  ~SimbodyTree();

  /// A body on a parent ("" for the ground) by a joint: "pin", "slider", "ball", "universal", "planar",
  /// "gimbal", "free", "weld", or "custom" with six axes (rotations, then translations). `coordinates` names
  /// its q, in Simbody's order (with Euler's angles). `reversed`: the joint's motion is its inverse.
  void add(const std::string& name, const std::string& parent, const std::string& joint,
           const SimbodyFrame& in_parent, const SimbodyFrame& in_body, const SimbodyMass& mass,
           const std::vector<std::string>& coordinates, const std::vector<SimbodyAxis>& axes = {},
           bool reversed = false);

  struct Motion {
    double q = 0, rate = 0;
  };
  /// The second derivatives of all coordinates at a state, under gravity.
  std::map<std::string, double> accelerations(const std::map<std::string, Motion>& state,
                                              const Eigen::Vector3d& gravity);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace borelli::test
