// Finds pairs of spheres, capsules and convex shapes that are too far apart to touch soon, by their bounding
// balls.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/equations/passes.hpp"

namespace borelli {

/// For contacts of spheres, capsules and convex shapes with each other.
class FarPairs {
 public:
  explicit FarPairs(const System& system);

  /// Marks in `rows` (a scan of rates or values) the constraints whose bounding balls, at their current
  /// speeds, stay farther apart than `distance` (m) for `time` (s). A marked row gets the gap of the balls, a
  /// lower bound of its own.
  void mark(const Kinematics& kinematics, double time, double distance, ConstraintRows& rows);

 private:
  struct Ball {
    int body = 0;
    Eigen::Vector3d centre;       // body axes, m
    double half = 0, radius = 0;  // m: half length of the segment; radius of the whole
    Eigen::Vector3d p, v;         // world axes
    double turns = 0;             // speed of the segment's ends about the centre, m/s
  };
  struct Pair {
    int constraint, row, a, b, contacts;
  };
  int ball(const System& system, const Site& site, const Eigen::Vector3d& centre, double half, double radius);

  std::vector<Ball> balls_;
  std::vector<Pair> pairs_;
};

}  // namespace borelli
