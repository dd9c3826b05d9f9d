// Pose and motion of every body: the pose (the paper's positioning function Phi_k), its first derivatives by
// the coordinates of its support, as velocities (equation 12), and its acceleration at zero acceleration of
// the free coordinates. The last is the second derivatives contracted with the velocities.
//
// The paper's q_0 = t: a driven coordinate is carried like a free one, with known rate and acceleration.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "dynamics/equations/pendant.hpp"
#include "dynamics/numbers/symmetric.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// Upper bound of the inertia of several bodies about a point, held rigid in any pose; plain numbers without
/// derivatives.
template <class T>
struct InertiaBoundOf {
  T mass = 0;   ///< kg
  T polar = 0;  ///< sum of half the traces of the tensors about the gravity centres, kg m^2
  T reach = 0;  ///< bound on the distance from the point to any gravity centre, m

  T polar_inertia() const { return polar + mass * reach * reach; }
  void add(const InertiaBoundOf& other) {
    mass += other.mass;
    polar += other.polar;
    reach = larger(reach, other.reach);
  }
};
/// The bound for bodies whose numbers are T.
template <class T>
using InertiaBound = InertiaBoundOf<std::remove_cvref_t<decltype(value_of(std::declval<T>()))>>;

/// Upper bound of a point's distance from the origin, in any axes.
template <class T>
auto distance_bound(const Eigen::Vector3<T>& point) {
  using std::abs;
  return value_of(T(abs(point[0]) + abs(point[1]) + abs(point[2])));
}

/// A body's inertial elements over a scalar that may carry derivatives (see Inertial).
template <class T>
struct alignas(line_alignment<T>) VariedInertial {
  T mass = 0;                                            ///< kg
  Eigen::Vector3<T> centre = Eigen::Vector3<T>::Zero();  ///< m, body's frame
  Eigen::Matrix3<T> tensor = Eigen::Matrix3<T>::Zero();  ///< about the gravity centre, kg m^2
  // For lanes only: precomputed by `set` and `settle`. (Flags come last, so that numbers stay within cache
  // lines.)
  InertiaBound<T> bound;
  PendantOf<T> pendant;
  bool principal = false;  ///< the body's axes are principal axes, which saves work
  bool round = false;      ///< `pendant` is valid in every lane

  /// Sets one lane; call settle() after the last.
  void set(int lane, const Inertial& inertial);
  void settle();
  Inertial lane(int lane) const;
};

/// The bound of one body about the origin of its frame.
template <class T, class Inertia>
InertiaBound<T> find_bound(const Inertia& inertial) {
  return {value_of(inertial.mass), 0.5 * value_of(inertial.tensor.trace()), distance_bound(inertial.centre)};
}
inline InertiaBound<double> bound_of(const Inertial& inertial) { return find_bound<double>(inertial); }
template <class T>
InertiaBound<T> bound_of(const VariedInertial<T>& inertial) {
  return is_lanes<T> ? inertial.bound : find_bound<T>(inertial);
}

template <class T>
void VariedInertial<T>::set(int lane, const Inertial& inertial) {
  mass.set(lane, inertial.mass);
  for (int i = 0; i < 3; ++i) {
    centre[i].set(lane, inertial.centre[i]);
    for (int j = 0; j < 3; ++j) tensor(i, j).set(lane, inertial.tensor(i, j));
  }
  set_lane(lane, find_pendant(inertial), pendant);
}

template <class T>
void VariedInertial<T>::settle() {
  bound = find_bound<T>(*this);
  principal = has_principal_axes(tensor);
  round = everywhere(pendant.roundness > least_roundness);
}

template <class T>
Inertial VariedInertial<T>::lane(int lane) const {
  Inertial out;
  out.mass = mass[lane];
  for (int i = 0; i < 3; ++i) {
    out.centre[i] = centre[i][lane];
    for (int j = 0; j < 3; ++j) out.tensor(i, j) = tensor(i, j)[lane];
  }
  return out;
}

inline bool has_principal_axes(const Inertial& inertial) { return has_principal_axes(inertial.tensor); }
template <class T>
bool has_principal_axes(const VariedInertial<T>& inertial) {
  return inertial.principal;
}
template <class T>
using InertialsOf = std::vector<std::conditional_t<std::is_same_v<T, double>, Inertial, VariedInertial<T>>>;

/// One body at one instant. World axes, SI.
template <class T>
struct BodyMotionOf {
  PoseOf<T> X;                                         ///< X_WB
  Eigen::Vector3<T> w = Eigen::Vector3<T>::Zero();     ///< angular velocity
  Eigen::Vector3<T> wdot = Eigen::Vector3<T>::Zero();  ///< its rate at the given free accelerations
  Eigen::Vector3<T> g = Eigen::Vector3<T>::Zero();  ///< gravity centre (B's origin for a body without mass)
  Eigen::Vector3<T> v = Eigen::Vector3<T>::Zero();  ///< velocity of g
  Eigen::Vector3<T> vdot = Eigen::Vector3<T>::Zero();  ///< its rate at the given free accelerations
  /// Velocity and acceleration of B's origin; recursive equations only.
  Eigen::Vector3<T> origin_v = Eigen::Vector3<T>::Zero(), origin_vdot = Eigen::Vector3<T>::Zero();
  int derivatives = 0;  ///< offset of its block in Kinematics::derivatives
};
using BodyMotion = BodyMotionOf<double>;

/// The rate of a switch's twist at constant velocities, as seen from the frame behind the switch, in W (see
/// Bending).
template <class T>
struct TwistRate {
  Eigen::Vector3<T> angular = Eigen::Vector3<T>::Zero(), linear = Eigen::Vector3<T>::Zero();

  /// That of the velocity of a point at `arm` from where the twist acts.
  Eigen::Vector3<T> at(const Eigen::Vector3<T>& arm) const { return linear + angular.cross(arm); }
};

/// Scratch and result of update_kinematics; one per thread. Sized once for a System.
template <class T>
struct KinematicsOf {
  /// Only the paper's equations keep `derivatives`; the recursive ones pass velocities and accelerations from
  /// body to body.
  explicit KinematicsOf(const System& system, Equations equations = Equations::lagrange);

  Equations equations;

  double t = 0;
  Eigen::VectorX<T> q;             ///< extended positions: free, then driven
  Eigen::VectorX<T> u;             ///< extended velocities: v, then driven rates
  Eigen::VectorX<T> acceleration;  ///< extended: the given free ones (zeros), then driven accelerations
  bool accelerated = false;        ///< free accelerations were given

  /// One row per extended coordinate: its unit twist (angular, linear) and the point where it acts. Padded,
  /// so that several rows can be loaded at once.
  Eigen::Matrix<T, Eigen::Dynamic, 9> twists;
  Eigen::Vector3<T> angular(int i) const { return {twists(i, 0), twists(i, 1), twists(i, 2)}; }
  Eigen::Vector3<T> linear(int i) const { return {twists(i, 3), twists(i, 4), twists(i, 5)}; }
  Eigen::Vector3<T> origin(int i) const { return {twists(i, 6), twists(i, 7), twists(i, 8)}; }

  /// Per coordinate, twice the angular velocity before its switch plus that of the switch itself. The second
  /// derivatives d2Phi/dq_i dq_j = Omega_min(i,j) x V_max(i,j), contracted with the velocities, are then the
  /// sum over i of convective[i] x V_i u_i.
  std::vector<Eigen::Vector3<T>> convective;
  /// What varying unit twists add to that, at the first coordinate of their switch; else zero. Empty if no
  /// switch bends, and for the recursive equations.
  std::vector<TwistRate<T>> twist_rates;

  std::vector<BodyMotionOf<T>> bodies;
  std::vector<Eigen::Vector3<T>> spins;  ///< see find_spins(); empty after every update
  /// Per touched body, six rows over its support: V_ki of the gravity centre (x, y, z), then Omega_ki. Empty
  /// for the recursive equations.
  std::vector<T> derivatives;

  /// Row c of body k's block (c = 0..2: V, 3..5: Omega), one number per coordinate of its support.
  const T* row(const System& system, int k, int c) const {
    return derivatives.data() + bodies[k].derivatives + c * system.bodies[k].support_count;
  }
};
using Kinematics = KinematicsOf<double>;

/// Sets positions, velocities and given accelerations of the coordinates, and those of drives from their
/// functions. The first part of update_kinematics.
template <class T>
void set_coordinates(const System& system, const Parameters& parameters, double t, const T* q, const T* v,
                     const T* a, KinematicsOf<T>& kinematics);

/// Fills `kinematics` for time t, positions q (nq) and velocities v (nv); `inertials` give the gravity
/// centres. Accelerations are those at the free accelerations a (nv; null: zeros). With null v only poses,
/// gravity centres and twists are filled.
template <class T>
void update_kinematics(const System& system, const Parameters& parameters, const InertialsOf<T>& inertials,
                       double t, const T* q, const T* v, const T* a, KinematicsOf<T>& kinematics);

inline void update_kinematics(const System& system, const Parameters& parameters, double t, const double* q,
                              const double* v, Kinematics& kinematics) {
  update_kinematics<double>(system, parameters, parameters.inertials, t, q, v, nullptr, kinematics);
}

}  // namespace borelli
