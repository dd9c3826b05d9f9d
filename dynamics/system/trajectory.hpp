// What a simulation hands out: plain arrays over the output times.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/system/certificate.hpp"

namespace borelli {

/// One row per output time.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Where one coordinate stands in q and v.
struct CoordinateInfo {
  std::string name;
  std::string kind;             ///< the switch's: "translation", "rotation", "ball"
  std::string solid;            ///< whose switch it is
  int q_index = 0, q_size = 1;  ///< a ball: 4, the quaternion (w, x, y, z)
  int v_index = 0, v_size = 1;  ///< a ball: 3, the angular velocity in its own axes
  bool angle = false;           ///< rad and rad/s; else m and m/s
};

struct Trajectory {
  std::vector<double> times;                ///< s, T of them, the first is the start
  std::vector<CoordinateInfo> coordinates;  ///< the free ones, in order of q and v
  Rows q;                                   ///< T x nq
  Rows v;                                   ///< T x nv
  Rows a;                                   ///< T x nv, accelerations

  std::vector<std::string> solids;  ///< every solid of the scene, welded ones too, in the scene's order
  std::vector<Pose> poses;          ///< X_WS of solid s at time t: [t * solids.size() + s]
  Rows gravity_centre;              ///< T x 3, of all moving solids together, world, m
  Rows linear_momentum;             ///< T x 3, of the same, kg m/s
  Rows angular_momentum;            ///< T x 3, about their gravity centre, kg m^2/s

  std::vector<std::string> multiplier_names;  ///< constraint's name, with [row] where it has several
  Rows multipliers;  ///< T x rows: the constraints' efforts along their rows, N or N m
  std::vector<std::string>
      contact_names;    ///< of unilateral constraints, with [contact] where one has several
  Rows contact_modes;   ///< T x contacts: 0 open, 1 sliding (or without friction), 2 sticking
  Rows contact_forces;  ///< T x contacts: normal forces, N or N m; friction is in multipliers

  std::vector<std::string> driven_names;  ///< driven coordinates, with [component] for a ball
  Rows driven_positions;                  ///< T x driven: m or rad; a driven ball: its rotation vector
  Rows driven_efforts;                    ///< T x driven: what the drive exerts, N or N m

  /// What each solid has from its parent through its joint (JointReaction), world axes; empty unless asked
  /// for (add_reactions).
  Rows reaction_points, reaction_forces, reaction_moments;  ///< T x 3 solids: m, N, N m
  Rows reaction_unique;                                     ///< T x solids: 1, or 0 where others would do

  std::vector<double> kinetic;    ///< J
  std::vector<double> potential;  ///< J: weight and springs
  std::vector<double> work;       ///< J since the start, on the system, by everything without a potential

  std::vector<double> step_times;  ///< s, the start of each accepted step
  std::vector<double> step_sizes;  ///< s

  Certificate certificate;

  const Pose& pose(std::size_t time, std::size_t solid) const { return poses[time * solids.size() + solid]; }
};

}  // namespace borelli
