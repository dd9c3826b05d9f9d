// Forward dynamics by the articulated-body algorithm, O(n), for states without active constraint rows. Three
// passes: outwards for the motion, inwards for the articulated inertias, outwards for the accelerations
// (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7). Equal to the paper's scan (lagrange.hpp)
// but for rounding.
//
// Motions and forces are in world axes at the origin of the frame they concern, so that no digits are lost
// far from the world's origin. Accelerations are the classical ones of that origin. Solved accelerations add
// to a *reference motion*, in which free coordinates have zero acceleration. Velocities then enter only the
// bodies' own forces, and no articulated inertia multiplies a velocity term.
//
// The passes are compiled separately for each kind of switch. A driven coordinate follows its drive: it is
// not eliminated, and the last pass returns its drive force. A free ball without armature is *loose*: it is
// eliminated at once, which reduces the articulated body to a symmetric 3x3 mass matrix at its pivot. Its
// reference motion need not turn with the frame before it, and it needs no unit twists.
#pragma once

#include <optional>

#include "dynamics/equations/kinematics.hpp"
#include "dynamics/equations/lagrange.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/equations/swings.hpp"
#include "dynamics/numbers/symmetric.hpp"
#include "dynamics/numbers/wrench.hpp"
#include "dynamics/system/alike_trees.hpp"

namespace borelli {

/// Motion of the frame after one step. World axes, SI.
template <class T>
struct alignas(line_alignment<T>) LinkMotion {
  Eigen::Matrix3<T> R;           ///< R_W
  Eigen::Vector3<T> r;           ///< from the origin before the step to this one
  Eigen::Vector3<T> w;           ///< angular velocity
  Eigen::Vector3<T> wdot, vdot;  ///< rate of w, and acceleration of the origin, in the reference motion
};

/// Position and velocity of that frame's origin. Efforts and energies need them; accelerations alone do not.
template <class T>
struct alignas(line_alignment<T>) LinkPlace {
  Eigen::Vector3<T> p, v;
};

/// Zero matrix. (GCC turns Eigen's loop into a memory clear, which for lanes takes two hundred cycles.)
template <class T>
Eigen::Matrix3<T> zero_by_entries() {
  Eigen::Matrix3<T> out;
  out(0, 0) = out(1, 0) = out(2, 0) = T(0);
  out(0, 1) = out(1, 1) = out(2, 1) = T(0);
  out(0, 2) = out(1, 2) = out(2, 2) = T(0);
  return out;
}

/// Articulated body at a frame's origin: an added acceleration (angular, linear) needs the wrench (I, H; H^T,
/// M) (angular, linear) + bias.
template <class T>
struct alignas(line_alignment<T>) ArticulatedBody {
  Symmetric3<T> I, M;
  Eigen::Matrix3<T> H = zero_by_entries<T>();
  Wrench<T> bias;
  InertiaBound<T> bound;  ///< scale for the test of small pivots
  bool extended = false;  ///< false: I, H and the moment of bias are zero
};

template <class T>
struct alignas(line_alignment<T>) LinkOf {
  LinkMotion<T> motion;
  LinkPlace<T> place;                 ///< set by place_links
  ArticulatedBody<T> body;            ///< sum of its children's articulated bodies
  Eigen::Vector3<T> turning;          ///< loose ball: wdot at zero joint acceleration
  Eigen::Vector3<T> at_rest;          ///< collapsed ball: I^-1 (moment of bias - torque)
  Eigen::Matrix3<T> by_push;          ///< collapsed ball: I^-1 H
  Eigen::Vector3<T> angular, linear;  ///< acceleration beyond the reference motion
  bool carries = false;               ///< inward pass: `body` holds a child already
  bool collapsed = false;  ///< ball eliminated at once: angular acceleration -at_rest - by_push linear
  bool hangs = false;      ///< pendant: only at_rest is set, in the body's axes (see PendantOf)
};

/// Per coordinate, results of the inward pass for the outward one.
template <class T>
struct alignas(line_alignment<T>) PivotOf {
  Eigen::Vector3<T> angular, linear;  ///< unit twist
  Wrench<T> U;                        ///< (I, H; H^T, M) times the unit twist
  T inverse;                          ///< inverse of the coordinate's articulated inertia, 1/kg or 1/(kg m^2)
  T rest;  ///< force left to accelerate it; of a drive: minus its force in the reference motion
};

/// Alike trees (same structure, different numbers) and the passes' data for them; one SIMD lane per tree.
struct SideBySide {
  SideBySide(const System& system, const AlikeTrees& trees);

  struct BodyOf {
    int first_step = 0;                           ///< index into `steps`
    std::array<Inertial, Quad::count> inertials;  ///< one per lane, at the last update
    VariedInertial<Quad> inertial;                ///< packed from these
    Eigen::Vector3<Quad> arm;                     ///< frame's origin to gravity centre, world axes
  };
  struct StepOf {
    AlikeTrees::Each steps;  ///< per tree
    AlikeTrees::Each q, u;   ///< per tree, offsets of positions and velocities
    int before = 0;          ///< previous one in `steps`, or by_carrier, by_world
    int first_pivot = 0;     ///< index into `pivots`
    bool stays = false, loose = false;
    LinkOf<Quad> link;
  };
  AlikeTrees trees;
  std::vector<BodyOf> bodies;  ///< one extra at the end marks the end of `steps`
  std::vector<StepOf> steps;
  std::vector<PivotOf<Quad>> pivots;
  static constexpr int by_carrier = -1, by_world = -2;  ///< values of `before`
  LinkOf<Quad> carrier;          ///< link that carries the trees, unless it is the world
  std::optional<Swings> swings;  ///< set if each tree is one body on a hinge fixed in the world
  bool swung = false;            ///< these passes moved only `swings`
};

/// A step in the order of the passes.
struct Joint {
  int step = 0;            ///< index of the step and of its link
  int before = -1;         ///< link before it; -1: the world
  int q = 0, u = 0;        ///< offsets of its positions and velocities
  int drive = -1;          ///< index of its drive; -1: free
  int body = -1;           ///< body whose frame follows it; -1: another step follows
  bool free_ball = false;  ///< a ball without a drive
};

/// Scratch; one per thread.
template <class T>
struct ArticulationOf {
  explicit ArticulationOf(const System& system);
  std::vector<LinkOf<T>> links;    ///< per step
  std::vector<PivotOf<T>> pivots;  ///< per extended coordinate
  std::vector<SideBySide> trees;   ///< double only: trees computed in SIMD lanes
  std::vector<int> alone;          ///< bodies outside `trees`, without the world, in order
  std::vector<Joint> joints;       ///< steps of `alone`, parents before children
  /// Lanes only: from this index in `joints` on, each joint is a hinge fixed in the world that carries a
  /// single body. For accelerations alone the pendulum equation is enough there.
  std::size_t first_swing = 0;
  bool swung = false;            ///< these passes used the pendulum equation; those links were not moved
  std::vector<int> frames;       ///< per body: last step before its frame; -1: the world
  bool every_body_moves = true;  ///< false (welds kept): find_accelerations does not apply
  bool placed = false;           ///< the places of the links belong to the last move_links

  /// Link of body b; null: the world.
  LinkOf<T>* link(int b) { return frames[b] < 0 ? nullptr : &links[frames[b]]; }
  const LinkOf<T>* link(int b) const { return frames[b] < 0 ? nullptr : &links[frames[b]]; }
};
using Articulation = ArticulationOf<double>;

/// Outward pass, in the reference motion or (for inverse_dynamics) with given accelerations a (nv, else
/// null). Fills only the coordinates of `kinematics`.
template <class T>
void move_links(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
                const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics,
                ArticulationOf<T>& articulation);

/// As move_links in the reference motion, for SIMD lanes of a system without drives; reads q and v in place.
/// Only accelerations without efforts may follow directly; all else needs set_coordinates first.
template <class T>
void move_links_alone(const Parameters& parameters, const InertialsOf<T>& inertials, const T* q, const T* v,
                      ArticulationOf<T>& articulation);

/// After move_links: fills poses and velocities of the bodies in `kinematics`, not their accelerations nor
/// twists. Efforts need them.
template <class T>
void find_bodies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                 KinematicsOf<T>& kinematics, ArticulationOf<T>& articulation);

/// After move_links without given accelerations: free accelerations a (nv) without constraints, and the
/// drives' generalised forces (driven_nv). `efforts` (after find_bodies) may be null for none; `given` (nv,
/// or null) adds to the generalised forces. Returns false if the articulated inertia of a coordinate is so
/// small against the rigid one that it may be rounding; use the mass matrix instead (factor_mass_matrix).
template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                        const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts, const T* given,
                        ArticulationOf<T>& articulation, T* a, T* drive_efforts);

/// After move_links: fills the energies of `terms`. `efforts` may be null for none.
template <class T>
void find_energies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                   const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts,
                   ArticulationOf<T>& articulation, LagrangeTermsOf<T>& terms);

}  // namespace borelli
