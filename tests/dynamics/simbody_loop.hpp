// A loop of links in Simbody, whose headers are C++17: so it stands behind an interface of its own. Built
// only where Simbody is installed.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

namespace borelli::test {

/// Links of a tree, and two of their points held together. SI units.
class SimbodyLoop {
 public:
  SimbodyLoop();
  ~SimbodyLoop();

  struct Link {
    double mass;
    Eigen::Vector3d centre, moments;  ///< in its axes, the moments about the centre
  };
  /// A link on a parent ("world") at p of it: by a hinge about an axis; by a ball where that is zero; over
  /// an ellipsoid where `radii` are not.
  void add(const std::string& name, const std::string& parent, const Eigen::Vector3d& p,
           const Eigen::Vector3d& axis, const Link& link, const Eigen::Vector3d& radii);
  /// The last thing added: p_a of one link is p_b of another.
  void close(const std::string& a, const Eigen::Vector3d& p_a, const std::string& b,
             const Eigen::Vector3d& p_b);

  /// A joint's position and velocity: an angle and its rate, or a quaternion (w, x, y, z) and the angular
  /// velocity in the parent's axes.
  void set(const std::string& name, const Eigen::VectorXd& q, const Eigen::VectorXd& v);
  /// Solves the equations of motion; the largest residual of the loop's positions and velocities.
  double solve();
  /// The rate of a joint's velocity.
  Eigen::VectorXd acceleration(const std::string& name) const;
  /// What the loop exerts on link a at its point, world axes.
  Eigen::Vector3d force() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace borelli::test
