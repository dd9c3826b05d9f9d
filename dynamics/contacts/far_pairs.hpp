// Which rounded things of a system are too far apart to touch soon: by the balls around them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/equations/passes.hpp"

namespace borelli {

/// Of contacts of spheres and capsules with each other.
class FarPairs {
 public:
  explicit FarPairs(const System& system);

  /// Marks in `rows` (a scan of rates or values) the constraints whose balls come no nearer than `distance`
  /// (m) within `time` (s) at the speeds that they have; the balls' gap stands for theirs, which is no less.
  void mark(const Kinematics& kinematics, double time, double distance, ConstraintRows& rows);

 private:
  struct Ball {
    int body = 0;
    Eigen::Vector3d centre;       // in the body's axes, m
    double half = 0, radius = 0;  // m: of the segment in it, and of all
    Eigen::Vector3d p, v;         // world axes
    double turns = 0;             // m/s, of the segment's ends about the centre
  };
  struct Pair {
    int constraint, row, a, b;
  };
  int ball(const System& system, const Site& site, const Eigen::Vector3d& centre, double half, double radius);

  std::vector<Ball> balls_;
  std::vector<Pair> pairs_;
};

}  // namespace borelli
