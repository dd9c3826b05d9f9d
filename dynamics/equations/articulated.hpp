// The accelerations themselves by articulated bodies, O(n), where no constraint row asks for the mass matrix:
// one pass outwards for the motion, one inwards for what each joint meets, one outwards for the accelerations
// (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7). Equal to the paper's scan (lagrange.hpp)
// but for rounding.
//
// Motions and forces are written in world axes at the origin of the frame they concern, so that no digits are
// lost far from the world's origin, and accelerations are the classical ones of that origin. They are what is
// added to a *reference motion*, in which free coordinates have no acceleration: velocities then enter the
// bodies' own forces only, and no inertia need be multiplied with them. The passes are compiled for each kind
// of switch by itself. A driven coordinate adds nothing and returns its effort. A ball whose rotor has no
// inertia leaves of all that it carries a mass to push, a symmetric 3x3 matrix: it turns as it must, so its
// reference motion need not turn with it, and it needs no axes.
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

/// How the frame after one step moves. World axes, SI.
template <class T>
struct alignas(line_alignment<T>) LinkMotion {
  Eigen::Matrix3<T> R;           ///< R_W
  Eigen::Vector3<T> r;           ///< from the origin of the frame before the step to this one's
  Eigen::Vector3<T> w;           ///< angular velocity
  Eigen::Vector3<T> wdot, vdot;  ///< its rate and the origin's acceleration, in the reference motion
};

/// Where the origin of that frame is, and its velocity. Accelerations do not ask for them, only what acts on
/// bodies and energies.
template <class T>
struct alignas(line_alignment<T>) LinkPlace {
  Eigen::Vector3<T> p, v;
};

/// Zero. (GCC makes of Eigen's loop one that clears memory: of lanes, by an instruction that takes two
/// hundred cycles.)
template <class T>
Eigen::Matrix3<T> zero_by_entries() {
  Eigen::Matrix3<T> out;
  out(0, 0) = out(1, 0) = out(2, 0) = T(0);
  out(0, 1) = out(1, 1) = out(2, 1) = T(0);
  out(0, 2) = out(1, 2) = out(2, 2) = T(0);
  return out;
}

/// All that a frame carries, free to follow: the wrench that adds an acceleration (angular, linear) is
/// (I, H; H^T, M) (angular, linear) + bias.
template <class T>
struct alignas(line_alignment<T>) ArticulatedBody {
  Symmetric3<T> I, M;
  Eigen::Matrix3<T> H = zero_by_entries<T>();
  Wrench<T> bias;
  InertiaBound<T> bound;  ///< what an entry of the mass matrix is compared with
  bool extended = false;  ///< else I, H and the moment of bias are zero
};

template <class T>
struct alignas(line_alignment<T>) LinkOf {
  LinkMotion<T> motion;
  LinkPlace<T> place;                 ///< after place_links
  ArticulatedBody<T> body;            ///< what its children let it feel
  Eigen::Vector3<T> turning;          ///< of a ball: wdot, had it no acceleration
  Eigen::Vector3<T> at_rest;          ///< of a collapsed one: I^-1 times bias' moment, less what acts on it
  Eigen::Matrix3<T> by_push;          ///< I^-1 H
  Eigen::Vector3<T> angular, linear;  ///< acceleration added
  bool carries = false;               ///< in the pass inwards: a child has been added to
  bool collapsed = false;  ///< a ball: its angular acceleration is -at_rest - by_push (the linear one)
  bool hangs = false;      ///< of a pendant: it has only at_rest, in the body's axes (see PendantOf)
};

/// What the inward pass leaves of a coordinate for the outward one.
template <class T>
struct alignas(line_alignment<T>) PivotOf {
  Eigen::Vector3<T> angular, linear;  ///< its unit twist
  Wrench<T> U;                        ///< (I, H; H^T, M) times its twist
  T inverse;                          ///< of what meets it alone, 1/kg or 1/(kg m^2)
  T rest;  ///< the effort that is left to accelerate it (of a drive: what the rest needs)
};

/// Alike trees, with what the passes keep of them; a lane is a tree.
struct SideBySide {
  SideBySide(const System& system, const AlikeTrees& trees);

  struct BodyOf {
    int first_step = 0;                           ///< in `steps`
    std::array<Inertial, Quad::count> inertials;  ///< of the trees' bodies as they last were
    VariedInertial<Quad> inertial;                ///< found from these
    Eigen::Vector3<Quad> arm;  ///< from the frame's origin to the gravity centre; world axes
  };
  struct StepOf {
    AlikeTrees::Each steps;  ///< of each tree
    AlikeTrees::Each q, u;   ///< where their positions and velocities begin
    int before = 0;          ///< which of `steps` comes before
    int first_pivot = 0;     ///< in `pivots`
    bool stays = false, loose = false;
    LinkOf<Quad> link;
  };
  AlikeTrees trees;
  std::vector<BodyOf> bodies;  ///< one more than the trees have: the last says where `steps` end
  std::vector<StepOf> steps;
  std::vector<PivotOf<Quad>> pivots;
  static constexpr int by_carrier = -1, by_world = -2;  ///< for `before`
  LinkOf<Quad> carrier;                                 ///< what carries them, if it is not the world
  std::optional<Swings> swings;  ///< where each tree is one body that swings about an axis of the world
  bool swung = false;            ///< in these passes: `swings` are all that has been moved
};

/// A step as the passes meet it.
struct Joint {
  int step = 0;            ///< its number among the steps, and its link's
  int before = -1;         ///< the link that it begins from; -1: the world
  int q = 0, u = 0;        ///< where its positions and velocities begin
  int drive = -1;          ///< its number among the drives; -1: free
  int body = -1;           ///< whose frame comes after it; -1: another step does
  bool free_ball = false;  ///< it turns freely, and without a drive
};

/// Scratch; one per thread.
template <class T>
struct ArticulationOf {
  explicit ArticulationOf(const System& system);
  std::vector<LinkOf<T>> links;    ///< per step
  std::vector<PivotOf<T>> pivots;  ///< per extended coordinate
  std::vector<SideBySide> trees;   ///< over doubles: what is computed side by side
  std::vector<int> alone;          ///< the other bodies but the world, in order
  std::vector<Joint> joints;       ///< their steps, a parent's before its children's
  /// In `joints`, of numbers side by side: from there on each is of a body that swings by itself about an
  /// axis of the world, which is all that accelerations alone need to know of it.
  std::size_t first_swing = 0;
  bool swung = false;            ///< in these passes: so these were not moved
  std::vector<int> frames;       ///< per body: the step after which its frame is; -1: the world
  bool every_body_moves = true;  ///< else (welds are kept) find_accelerations does not apply
  bool placed = false;           ///< the links' places are those of the last move_links

  /// Of body b; null: the world's.
  LinkOf<T>* link(int b) { return frames[b] < 0 ? nullptr : &links[frames[b]]; }
  const LinkOf<T>* link(int b) const { return frames[b] < 0 ? nullptr : &links[frames[b]]; }
};
using Articulation = ArticulationOf<double>;

/// The pass outwards, in the reference motion or (for inverse_dynamics) with given accelerations a (nv, else
/// null). Of `kinematics` it fills the coordinates alone.
template <class T>
void move_links(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials, double t,
                const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics,
                ArticulationOf<T>& articulation);

/// As move_links in the reference motion of a system without drives, over numbers side by side: coordinates
/// are read where they lie. What follows of it, but for accelerations without efforts, asks for
/// set_coordinates first.
template <class T>
void move_links_alone(const Parameters& parameters, const InertialsOf<T>& inertials, const T* q, const T* v,
                      ArticulationOf<T>& articulation);

/// After move_links: the poses and velocities of the bodies of `kinematics` (not its accelerations, nor what
/// it keeps per coordinate). What acts on bodies asks for them.
template <class T>
void find_bodies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                 KinematicsOf<T>& kinematics, ArticulationOf<T>& articulation);

/// After move_links without them: the free accelerations a (nv) without constraints, and what the drives
/// exert (driven_nv). `efforts` (after find_bodies) may be null for none; `given` (nv, or null) is added to
/// the generalized efforts. False where a coordinate meets so little inertia beside what it carries that
/// rounding may have made it: then A must decide (factor_mass_matrix).
template <class T>
bool find_accelerations(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                        const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts, const T* given,
                        ArticulationOf<T>& articulation, T* a, T* drive_efforts);

/// After move_links: the energies of `terms`. `efforts` may be null for none.
template <class T>
void find_energies(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                   const KinematicsOf<T>& kinematics, const EffortSumsOf<T>* efforts,
                   ArticulationOf<T>& articulation, LagrangeTermsOf<T>& terms);

}  // namespace borelli
