// The result of a simulation: plain arrays over the output times.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/system/certificate.hpp"

namespace borelli {

/// One row per output time.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Name, and place in q and v, of one coordinate.
struct CoordinateInfo {
  std::string name;
  std::string kind;             ///< of its switch: "translation", "rotation", "screw", "ball"
  std::string solid;            ///< the solid of the switch
  int q_index = 0, q_size = 1;  ///< a ball: 4, the quaternion (w, x, y, z)
  int v_index = 0, v_size = 1;  ///< a ball: 3, the angular velocity in its own axes
  bool angle = false;           ///< rad and rad/s; else m and m/s
};

struct Trajectory {
  std::vector<double> times;                ///< s, T output times; the first is the start
  std::vector<CoordinateInfo> coordinates;  ///< the free ones, in order of q and v
  Rows q;                                   ///< T x nq
  Rows v;                                   ///< T x nv
  Rows a;                                   ///< T x nv, accelerations

  std::vector<std::string> solids;  ///< every solid of the scene, welded ones too, in the scene's order
  std::vector<Pose> poses;          ///< X_WS of solid s at time t: [t * solids.size() + s]
  Rows gravity_centre;              ///< T x 3, centre of mass of all moving solids, world, m
  Rows linear_momentum;             ///< T x 3, of the same, kg m/s
  Rows angular_momentum;            ///< T x 3, about their centre of mass, kg m^2/s

  std::vector<std::string> multiplier_names;  ///< name of the constraint, with [row] if it has several rows
  Rows multipliers;                           ///< T x rows: constraint forces along the rows, N or N m
  std::vector<std::string> contact_names;  ///< of unilateral constraints, with [contact] if one has several
  Rows contact_modes;   ///< T x contacts: 0 open, 1 sliding (or without friction), 2 sticking
  Rows contact_forces;  ///< T x contacts: normal forces, N or N m; friction is in multipliers

  std::vector<std::string> driven_names;  ///< driven coordinates, with [component] for a ball
  Rows driven_positions;                  ///< T x driven: m or rad; a driven ball: its rotation vector
  Rows driven_efforts;                    ///< T x driven: generalised forces of the drives, N or N m

  /// Joint reaction of the parent on each solid (JointReaction), world axes; empty unless asked for
  /// (add_reactions).
  Rows reaction_points, reaction_forces, reaction_moments;  ///< T x 3 solids: m, N, N m
  Rows reaction_unique;  ///< T x solids: 1 if the reaction is unique, 0 if others balance too

  std::vector<double> kinetic;    ///< J
  std::vector<double> potential;  ///< J: weight and springs
  std::vector<double> work;       ///< J since the start: work on the system by everything without a potential

  std::vector<double> step_times;  ///< s, the start of each accepted step
  std::vector<double> step_sizes;  ///< s

  Certificate certificate;

  const Pose& pose(std::size_t time, std::size_t solid) const { return poses[time * solids.size() + solid]; }
};

}  // namespace borelli
