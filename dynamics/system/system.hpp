// A compiled scene. The structure is flat and immutable. Its numbers (Parameters) are separate, so that a
// sweep or an optimisation changes them without compiling again.
//
// Moving switches are numbered in the order of the tree as `steps`; each has its coordinates, free or driven.
// The extended velocity u holds the free velocities v first, then the rates of the driven coordinates. These
// rates represent the paper's coordinate 0, time.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/alike_trees.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"

namespace borelli {

/// Time, positions and velocities of the free coordinates.
struct State {
  double t = 0;
  Eigen::VectorXd q;  ///< nq
  Eigen::VectorXd v;  ///< nv
};

/// A constant pose, marked if it is the identity or a pure translation, to save work.
struct Placement {
  enum class Form { identity, shift, general };
  Pose X;
  Form form = Form::identity;

  Placement() = default;
  explicit Placement(const Pose& pose);
};

/// X_AC = X_AB X_BC
template <class T>
PoseOf<T> operator*(const PoseOf<T>& X_AB, const Placement& X_BC) {
  if (X_BC.form == Placement::Form::identity) return X_AB;
  if (X_BC.form == Placement::Form::shift) return {X_AB.R, X_AB * X_BC.X.p};
  return X_AB * X_BC.X;
}

/// p_A = X_AB p_B
inline Eigen::Vector3d operator*(const Placement& X_AB, const Eigen::Vector3d& p_B) {
  return X_AB.form == Placement::Form::identity ? p_B : X_AB.X * p_B;
}

/// The functions of a driven switch and, for a ball, the initial orientation that they rotate.
struct Drive {
  std::vector<TimeFunction> functions;
  Quaternion initial = identity_quaternion();
};

/// The numbers of a compiled scene. A copy may change any of them, but not their count.
struct Parameters {
  Eigen::Vector3d gravity{0, 0, -9.81};  ///< m/s^2, world
  std::vector<Placement> placements;     ///< per step: pose of its first frame in the frame before it
  std::vector<SwitchKind> kinds;         ///< per step; unit axes
  std::vector<double> armatures;         ///< per step, kg m^2 or kg
  std::vector<Drive> drives;             ///< per driven step
  std::vector<Inertial> inertials;       ///< per body, in the body's frame
  std::vector<Placement> solid_places;   ///< per solid: X_BS, its pose in its body
  std::vector<Effort> efforts;
  std::vector<Constraint> constraints;
};

/// A moving switch.
struct SwitchStep {
  int q = 0, u = 0;    ///< first index of its positions and velocities in the extended arrays
  int nq = 0, nv = 0;  ///< their numbers
  int drive = -1;      ///< index among the drives; -1: free
  bool rotates = false, slides = false;  ///< whether its unit twists have an angular, a linear part
};

/// A rigid body: solids welded together. Body 0 is the world, with all that is welded to it.
struct Body {
  int parent = 0;                      ///< index of the parent body, smaller than its own
  int first_step = 0, step_count = 0;  ///< the switches from the parent to this body's frame B
  std::ptrdiff_t first_support = 0;    ///< index of its first coordinate in Branches::support
  int support_count = 0;               ///< number of coordinates that it depends on
  std::vector<int> solids;             ///< indices of the solids of the scene merged in it
  bool massive = false;                ///< has inertia
  bool touched = false;                ///< something acts on it: inertia, effort or constraint
  int group = 0;                       ///< which independent group it belongs to (System::groups)
};

/// A solid, in its body, that an effort or constraint acts on.
struct Site {
  int body = -1,
      solid = -1;  ///< -1, -1: an optional site that is not given; solid -1 of body 0: the world itself
};

/// A coordinate of an effort or constraint.
struct CoordinateSite {
  int q = -1, u = -1;                       ///< first indices in the extended arrays; -1: locked
  double value = 0;                         ///< of a locked scalar
  Quaternion turn = identity_quaternion();  ///< of a locked ball
};

/// The sites of one effort or constraint, in the order of its fields: ranges of System::sites and
/// System::coordinate_sites; for a constraint also its rows.
struct Action {
  int first_site = 0, site_count = 0;
  int first_coordinate = 0, coordinate_count = 0;
  int first_row = 0, row_count = 0;
  int group = 0;  ///< group of the bodies and coordinates that it acts on
};

struct System;

/// The supports: which coordinates move which bodies. Memory grows with the square of the length of a chain.
struct Branches {
  std::vector<int> support;  ///< per body, the coordinates (u indices) that it depends on, root first
  /// Per free coordinate, the free ones before it on its chain, root first: the nonzero entries of the mass
  /// matrix. first_ancestor holds the nv + 1 offsets of these lists.
  std::vector<int> ancestors;
  std::vector<std::ptrdiff_t> first_ancestor;

  /// The memory of a system's branches, bytes.
  static double bytes(const System& system);
};

/// The branches of a System, computed on first use: articulated-body accelerations need none. Copies of a
/// System share them. Thread-safe.
class BranchesOnDemand {
 public:
  const Branches& of(const System& system) const {
    const Branches* const ready = shared_->ready.load(std::memory_order_acquire);
    return ready ? *ready : lay_out(system);
  }

 private:
  struct Shared {
    std::atomic<const Branches*> ready = nullptr;
    std::mutex at_work;
    Branches branches;
  };
  const Branches& lay_out(const System& system) const;
  std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
};

struct System {
  std::string scene;                 ///< its name
  int nq = 0, nv = 0;                ///< free positions and velocities
  int driven_nq = 0, driven_nv = 0;  ///< driven ones
  int rows = 0;                      ///< of all constraints
  double length = 1;                 ///< m, the size of the scene; reference for rounding
  /// Number of independent groups: trees, joined where an effort or constraint acts on several. No energy
  /// passes between groups. At least one; the world, and what acts on it alone, count to the first.
  int groups = 1;
  std::vector<SwitchStep> steps;
  std::vector<Body> bodies;
  std::vector<AlikeTrees> alike_trees;  ///< from find_alike_trees()
  BranchesOnDemand branches_on_demand;
  const Branches& branches() const { return branches_on_demand.of(*this); }
  std::vector<Site> sites;
  std::vector<CoordinateSite> coordinate_sites;
  std::vector<Action> efforts, constraints;
  std::vector<Contact> contacts;  ///< of the unilateral constraints, in the order of their rows

  std::vector<std::string> solids;          ///< names, in the scene's order
  std::vector<int> solid_bodies;            ///< the body of each solid
  std::vector<CoordinateInfo> coordinates;  ///< free ones
  std::vector<CoordinateInfo> driven;       ///< driven ones; indices start at 0
  std::vector<std::string> row_names;       ///< of constraint rows
  std::vector<int> velocity_groups;         ///< the group of each extended velocity component
  std::vector<double> velocity_scale;  ///< per free velocity component: scale of its coordinate, and of its
                                       ///< rate per second: a length of what it moves, m, or 1 rad
  std::vector<double> row_scale;       ///< scale of the residual of a row: a length of what it ties, m, or 1
  std::vector<int> row_constraint;     ///< the constraint of each row
  std::vector<char> kinematic_rows;    ///< per row: whether it constrains velocities only (Kinematic)
  std::vector<std::string> constraint_names;
  std::string file;  ///< source file of the scene; empty: none
  struct LimitedCoordinate {
    int coordinate;             ///< index in `coordinates`
    std::vector<Range> ranges;  ///< one per velocity component
  };
  std::vector<LimitedCoordinate> ranges;

  State initial;                ///< as the scene gives it, not yet assembled
  Parameters parameters;        ///< as the scene gives them
  SimulationSettings settings;  ///< as the scene gives them

  int size() const { return nv + driven_nv; }  ///< of the extended velocity
  bool has_kinematic_rows() const;
  int bilateral_rows() const;  ///< number of rows that are not contacts
  /// The prefix of an error about a constraint row: its place in the file of the scene, and its name.
  std::string row_place(int row) const;
  /// The solids that a constraint ties, for a sentence: "'a' and 'b'".
  std::string tied_solids(int constraint) const;
  /// The name of a group: that of its first solid.
  std::string group_name(int group) const;
  /// The name of the coordinate that velocity component i (free) belongs to, with its axis for a ball.
  std::string velocity_name(int i) const;
  std::vector<std::string> velocity_names() const;  ///< of all free ones
};

/// How solids welded to their parents are compiled.
enum class Welds {
  merged,  ///< one body with the parent
  kept     ///< a body of its own, so that the load through the weld can be computed (reaction.hpp)
};

/// Checks a scene and compiles it to a flat System: merges welded solids into their parents, folds locked
/// coordinates, computes the support of each body. Errors name the wrong solid, coordinate, effort or
/// constraint.
Result<System> compile(const Scene& scene, Welds welds = Welds::merged);

}  // namespace borelli
