// A loop of links in Simbody, behind an interface because Simbody's headers are C++17. Needs Simbody.
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
    Eigen::Vector3d centre, moments;  ///< in body axes; the moments about the centre
  };
  /// Adds a link at point p of a parent ("world" is one): on a hinge about an axis; on a ball if the axis is
  /// zero; over an ellipsoid if `radii` are not zero.
  void add(const std::string& name, const std::string& parent, const Eigen::Vector3d& p,
           const Eigen::Vector3d& axis, const Link& link, const Eigen::Vector3d& radii);
  /// Closes the loop, after all links: p_a of one link coincides with p_b of another.
  void close(const std::string& a, const Eigen::Vector3d& p_a, const std::string& b,
             const Eigen::Vector3d& p_b);

  /// Sets a joint's position and velocity: an angle and its rate, or a quaternion (w, x, y, z) and the
  /// angular velocity in the parent's axes.
  void set(const std::string& name, const Eigen::VectorXd& q, const Eigen::VectorXd& v);
  /// Solves the equations of motion. Returns the largest residual of the loop's positions and velocities.
  double solve();
  /// The rate of a joint's velocity.
  Eigen::VectorXd acceleration(const std::string& name) const;
  /// Force of the loop on link a at its point, world axes.
  Eigen::Vector3d force() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace borelli::test
