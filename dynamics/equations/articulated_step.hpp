// One step's part in the three passes of articulated.hpp and in inverse dynamics, compiled separately for
// each kind of switch. Only articulated_side.hpp, articulated.cpp and inverse_dynamics.cpp include this file.
#pragma once

#include "dynamics/equations/articulated.hpp"

namespace borelli::articulated {

using Eigen::Matrix3;
using Eigen::Vector3;

/// Whether a switch turns freely about a point, with unit twists along its body's axes (a ball).
template <class Kind>
constexpr bool turns_freely = requires {
  Kind::turns_freely;
};

// ---- outwards: motion ----

template <class T, class Where>
void place(const Where& placement, PoseOf<T>& X) {
  if (placement.form == Placement::Form::identity) return;
  X.p = X.R * placement.X.p;
  if (placement.form == Placement::Form::general) X.R = X.R * placement.X.R;
}

/// Motion after a step with positions q and velocities u, from the motion before it (null: the world).
/// `acceleration`: of a drive, or given; else null. Stores the unit twists in the pivots, except a ball's.
/// For a loose ball, `turning` receives wdot at zero joint acceleration, and wdot becomes zero.
template <class Kind, class Where, class T>
LinkMotion<T> move(const Kind& kind, const Where& placement, bool loose, const LinkMotion<T>* before,
                   const T* q, const T* u, const T* acceleration, PivotOf<T>* pivots, Vector3<T>& turning) {
  LinkMotion<T> to;
  PoseOf<T> X;  // relative to the origin of the frame before, so that no digits are lost far from the world's
                // origin
  if (before) {
    X.R = before->R;
    place(placement, X);
  } else {
    X.R = placement.X.R.template cast<T>();
    X.p = placement.X.p.template cast<T>();
  }
  Vector3<T> angular[Kind::nv + 1], linear[Kind::nv + 1];
  Vector3<T> angular_rate, linear_rate;  // as seen from the frame behind the step
  if constexpr (Bending<Kind>)
    kind.advance(q, u, X, angular, linear, angular_rate, linear_rate);
  else
    kind.advance(q, X, angular, linear);
  to.R = X.R;
  to.r = X.p;
  Vector3<T> w = Vector3<T>::Zero(), v = Vector3<T>::Zero();  // relative velocities of the step
  for (int i = 0; i < Kind::nv; ++i) {
    if (Kind::rotates) w += u[i] * angular[i];
    if (Kind::slides) v += u[i] * linear[i];
  }
  if (before) {
    const Vector3<T> carrier = before->w;
    to.w = carrier;
    to.vdot = before->vdot;
    to.wdot = before->wdot;
    if (Kind::slides || placement.form != Placement::Form::identity)
      to.vdot += to.wdot.cross(to.r) + carrier.cross(carrier.cross(to.r));
    if (Kind::slides) to.vdot += (2 * carrier + w).cross(v);
    if (Kind::rotates) to.wdot += carrier.cross(w);
    if (Kind::rotates) to.w += w;
  } else {
    to.w = w;
    to.wdot.setZero();
    to.vdot.setZero();
    if (Kind::slides && Kind::rotates) to.vdot = w.cross(v);
  }
  if constexpr (Bending<Kind>) {
    to.wdot += angular_rate;
    to.vdot += linear_rate;
  }
  if (turns_freely<Kind> && loose) {
    turning = to.wdot;
    to.wdot.setZero();
    return to;
  }
  for (int i = 0; i < Kind::nv && !turns_freely<Kind>; ++i) {
    if (Kind::rotates) pivots[i].angular = angular[i];
    if (Kind::slides) pivots[i].linear = linear[i];
  }
  if (!acceleration) return to;
  for (int i = 0; i < Kind::nv; ++i) {
    if (Kind::rotates) to.wdot += acceleration[i] * angular[i];
    if (Kind::slides) to.vdot += acceleration[i] * linear[i];
  }
  return to;
}

/// Position and velocity after a step with velocities u, from the link before it (null: the world).
template <class Kind, class T>
void find_place(const LinkOf<T>* before, const T* u, const PivotOf<T>* pivots, LinkOf<T>& link) {
  const Vector3<T> r = link.motion.r;
  Vector3<T> p = r, v = Vector3<T>::Zero();
  if (before) {
    p += before->place.p;
    v = before->place.v + before->motion.w.cross(r);
  }
  for (int i = 0; i < Kind::nv && Kind::slides; ++i) v += u[i] * pivots[i].linear;
  link.place = {p, v};
}

// ---- inwards: articulated inertias ----

/// A body's inertia about the origin of its frame, world axes. d: from there to the gravity centre; h = mass
/// d.
template <class T, class Inertia>
Symmetric3<T> inertia_about_origin(const Matrix3<T>& R, const Inertia& inertial, const Vector3<T>& d,
                                   const Vector3<T>& h) {
  const auto& tensor = inertial.tensor;
  T all = h.dot(d);
  const auto entry = [&](const Vector3<T>& a, const Vector3<T>& b, int i, int j) {
    return a[i] * R(j, 0) + b[i] * R(j, 1) - h[i] * d[j];
  };
  if (has_principal_axes(inertial)) {
    // R diag(a, b, c) R^T = c 1 + (a - c) R_0 R_0^T + (b - c) R_1 R_1^T
    const T last = tensor(2, 2);
    const Vector3<T> a = (tensor(0, 0) - last) * R.col(0), b = (tensor(1, 1) - last) * R.col(1);
    all += last;
    return {all + entry(a, b, 0, 0), entry(a, b, 0, 1), entry(a, b, 0, 2),
            all + entry(a, b, 1, 1), entry(a, b, 1, 2), all + entry(a, b, 2, 2)};
  }
  Symmetric3<T> I = symmetric_product(Matrix3<T>(R * tensor), R.transpose());
  I.subtract(h, d);
  I.xx += all, I.yy += all, I.zz += all;
  return I;
}

/// A body's kinetic and potential energy.
template <class T, class Inertia>
std::pair<T, T> energies(const Inertia& inertial, const Eigen::Vector3d& gravity, const LinkOf<T>& link) {
  const LinkMotion<T>& motion = link.motion;
  const T mass = inertial.mass;
  const Vector3<T> d = motion.R * inertial.centre, w = motion.R.transpose() * motion.w;
  const Vector3<T> v = link.place.v + motion.w.cross(d);
  const Vector3<T> momentum = times(inertial.tensor, has_principal_axes(inertial), w);
  return {0.5 * (mass * v.squaredNorm() + w.dot(momentum)),
          -mass * (gravity.dot(link.place.p) + gravity.dot(d))};
}

/// Sets `to` to a, or adds a to it.
template <bool added, class T>
void put(const T& a, T& to) {
  if constexpr (added)
    to += a;
  else
    to = a;
}

/// Inertia and bias (inertial force minus weight) of one rigid body, set or `added` to `to`. `turning`:
/// whether wdot may differ from zero.
template <bool added, class T, class Inertia>
void put_own(const Inertia& inertial, const Eigen::Vector3d& gravity, const LinkMotion<T>& motion,
             bool turning, ArticulatedBody<T>& to) {
  const T mass = inertial.mass;
  const Matrix3<T>& R = motion.R;
  const Vector3<T> w = motion.w, d = R * inertial.centre, h = mass * d;
  const Symmetric3<T> I = inertia_about_origin<T>(R, inertial, d, h);
  const Vector3<T> momentum = I * w, force = motion.vdot - gravity;
  Vector3<T> n = w.cross(momentum) + h.cross(force), f = mass * force + w.cross(w.cross(h));
  if (turning) {
    n += I * motion.wdot;
    f += motion.wdot.cross(h);
  }
  put<added>(n, to.bias.n), put<added>(f, to.bias.f);
  put<added>(I, to.I);
  Matrix3<T>& H = to.H;
  put<added>(h[0], H(2, 1)), put<added>(h[1], H(0, 2)), put<added>(h[2], H(1, 0));
  put<added>(T(-h[0]), H(1, 2)), put<added>(T(-h[1]), H(2, 0)), put<added>(T(-h[2]), H(0, 1));
  put<added>(mass, to.M.xx), put<added>(mass, to.M.yy), put<added>(mass, to.M.zz);
  if constexpr (!added) {
    for (int i = 0; i < 3; ++i) H(i, i) = T(0);
    to.M.xy = to.M.xz = to.M.yz = T(0);
  }
  const InertiaBound<T> bound = bound_of(inertial);
  if constexpr (added)
    to.bound.add(bound);
  else
    to.bound = bound;
  to.extended = true;
}

template <class T>
void add(const ArticulatedBody<T>& body, ArticulatedBody<T>& to) {
  to.M += body.M;
  to.bias.f += body.bias.f;
  to.bound.add(body.bound);
  if (!body.extended) return;
  to.extended = true;
  to.I += body.I;
  to.H += body.H;
  to.bias.n += body.bias.n;
}

/// Zeroes I, H and moment of a body that is not extended: an eliminated ball leaves old entries there.
template <class T>
void flatten(ArticulatedBody<T>& body) {
  body.I = {};
  body.H.setZero();
  body.bias.n.setZero();
}

/// Moves an articulated body's origin by -r.
template <class T>
void move_origin(const Vector3<T>& r, ArticulatedBody<T>& body) {
  const Symmetric3<T> M = body.M;
  body.bound.reach += distance_bound(r);
  // H' = H + [r]x M, I' = I - H [r]x + [r]x H'^T
  Matrix3<T> G;
  G << r[1] * M.xz - r[2] * M.xy, r[1] * M.yz - r[2] * M.yy, r[1] * M.zz - r[2] * M.yz,
      r[2] * M.xx - r[0] * M.xz, r[2] * M.xy - r[0] * M.yz, r[2] * M.xz - r[0] * M.zz,
      r[0] * M.xy - r[1] * M.xx, r[0] * M.yy - r[1] * M.xy, r[0] * M.yz - r[1] * M.xz;
  const Vector3<T> n = r.cross(body.bias.f);
  if (!body.extended) {
    body.extended = true;
    body.bias.n = n;
    body.I = {r[1] * G(0, 2) - r[2] * G(0, 1), r[1] * G(1, 2) - r[2] * G(1, 1),
              r[1] * G(2, 2) - r[2] * G(2, 1), r[2] * G(1, 0) - r[0] * G(1, 2),
              r[2] * G(2, 0) - r[0] * G(2, 2), r[0] * G(2, 1) - r[1] * G(2, 0)};
    body.H = G;
    return;
  }
  const Matrix3<T> H = body.H;
  G += H;
  body.bias.n += n;
  Symmetric3<T>& I = body.I;
  I.xx += r[1] * (H(0, 2) + G(0, 2)) - r[2] * (H(0, 1) + G(0, 1));
  I.xy += r[2] * H(0, 0) - r[0] * H(0, 2) + r[1] * G(1, 2) - r[2] * G(1, 1);
  I.xz += r[0] * H(0, 1) - r[1] * H(0, 0) + r[1] * G(2, 2) - r[2] * G(2, 1);
  I.yy += r[2] * (H(1, 0) + G(1, 0)) - r[0] * (H(1, 2) + G(1, 2));
  I.yz += r[0] * H(1, 1) - r[1] * H(1, 0) + r[2] * G(2, 0) - r[0] * G(2, 2);
  I.zz += r[0] * (H(2, 1) + G(2, 1)) - r[1] * (H(2, 0) + G(2, 0));
  body.H = G;
}

/// Eliminates a loose ball at once, with `torque` (world axes) acting on it. The articulated body reduces to
/// the mass matrix M at the pivot. Returns false if its inertia is too thin to be inverted; eliminate axis by
/// axis. Unless a torque acts, entries that become zero are not written (see flatten), since move_origin
/// overwrites them nearly always.
template <class T>
bool collapse(const Vector3<T>& torque, bool acted, bool at_root, ArticulatedBody<T>& body, LinkOf<T>& link) {
  const Symmetric3<T>& I = body.I;
  Symmetric3<T> inverse{I.yy * I.zz - I.yz * I.yz, I.xz * I.yz - I.xy * I.zz, I.xy * I.yz - I.xz * I.yy,
                        I.xx * I.zz - I.xz * I.xz, I.xy * I.xz - I.xx * I.yz, I.xx * I.yy - I.xy * I.xy};
  const T determinant = I.xx * inverse.xx + I.xy * inverse.xy + I.xz * inverse.xz;
  // The minors are differences: they lose as many digits as this ratio has.
  const T size = I.trace();
  if (!everywhere(determinant > least_roundness * size * size * size) ||
      !everywhere(size > 1e-8 * body.bound.polar_inertia()))
    return false;
  const T scale = 1 / determinant;
  inverse = {scale * inverse.xx, scale * inverse.xy, scale * inverse.xz,
             scale * inverse.yy, scale * inverse.yz, scale * inverse.zz};
  link.collapsed = true;
  if (acted) body.bias.n -= torque;
  const Vector3<T> at_rest = inverse * body.bias.n;
  link.at_rest = at_rest;
  if (at_root) return true;
  const Matrix3<T>& H = body.H;
  Matrix3<T> G;
  for (int j = 0; j < 3; ++j) G.col(j) = inverse * Vector3<T>(H.col(j));
  link.by_push = G;
  const auto entry = [&](int i, int j) { return H(0, i) * G(0, j) + H(1, i) * G(1, j) + H(2, i) * G(2, j); };
  body.M.xx -= entry(0, 0), body.M.xy -= entry(0, 1), body.M.xz -= entry(0, 2);
  body.M.yy -= entry(1, 1), body.M.yz -= entry(1, 2), body.M.zz -= entry(2, 2);
  body.bias.f -= H.transpose() * at_rest;
  body.extended = acted;
  if (acted) {
    flatten(body);
    body.bias.n = torque;
  }
  return true;
}

/// The same for a pendant, from constants in its own axes (see PendantOf). `applied`: wrench of the efforts
/// on it, at its frame's origin; or null. `effort`, `given`: torques on the ball, in its own axes; or null.
template <class T, class Inertia>
void let_hang(const Inertia& inertial, const Eigen::Vector3d& gravity, const Wrench<T>* applied,
              const T* effort, const T* given, bool at_root, ArticulatedBody<T>& body, LinkOf<T>& link) {
  const PendantOf<T>& pendant = inertial.pendant;
  const LinkMotion<T>& motion = link.motion;
  const Matrix3<T>& R = motion.R;
  const Vector3<T> w = R.transpose() * motion.w, fall = motion.vdot - gravity;
  Vector3<T> n = w.cross(pendant.I * w) + pendant.h.cross(Vector3<T>(R.transpose() * fall));
  Vector3<T> torque = Vector3<T>::Zero();  // on the ball
  for (int i = 0; i < 3; ++i) {
    if (effort) torque[i] += effort[i];
    if (given) torque[i] += given[i];
  }
  const bool acted = effort || given;
  if (acted) n -= torque;
  if (applied) n -= R.transpose() * applied->n;
  const Vector3<T> at_rest = pendant.inverse * n;
  link.at_rest = at_rest;
  link.collapsed = link.hangs = true;
  if (at_root) return;
  const T mass = inertial.mass;
  body.bias.f = mass * fall + R * (w.cross(w.cross(pendant.h)) + pendant.h.cross(at_rest));
  if (applied) body.bias.f -= applied->f;
  const Vector3<T> a = R * pendant.yields[0], b = R * pendant.yields[1];
  const auto entry = [&](int i, int j) { return -a[i] * a[j] - b[i] * b[j]; };
  body.M = {mass + entry(0, 0), entry(0, 1), entry(0, 2),
            mass + entry(1, 1), entry(1, 2), mass + entry(2, 2)};
  body.bound = bound_of(inertial);
  body.extended = acted;
  if (acted) {
    flatten(body);
    body.bias.n = R * torque;
  }
}

/// The power of a wrench along the unit twist of a coordinate.
template <class Kind, class T>
T power(const PivotOf<T>& pivot, const Wrench<T>& wrench) {
  if constexpr (!Kind::slides)
    return pivot.angular.dot(wrench.n);
  else if constexpr (!Kind::rotates)
    return pivot.linear.dot(wrench.f);
  else
    return pivot.angular.dot(wrench.n) + pivot.linear.dot(wrench.f);
}

/// U: the wrench that gives the articulated body unit acceleration of a coordinate.
template <class Kind, class T>
void find_wrench(const ArticulatedBody<T>& body, PivotOf<T>& pivot) {
  const Vector3<T>&w = pivot.angular, &l = pivot.linear;
  if constexpr (!Kind::slides)
    pivot.U = {body.I * w, body.H.transpose() * w};
  else if constexpr (!Kind::rotates)
    pivot.U = {body.H * l, body.M * l};
  else
    pivot.U = {body.I * w + body.H * l, body.H.transpose() * w + body.M * l};
}

/// Eliminates the coordinate of a pivot: I^A <- I^A - U U^T / D, and the bias likewise.
template <class T>
void release(const PivotOf<T>& pivot, ArticulatedBody<T>& body) {
  const Vector3<T> f = pivot.inverse * pivot.U.f;
  body.M.subtract(f, pivot.U.f);
  body.bias.f += pivot.rest * f;
  if (!body.extended) return;
  const Vector3<T> n = pivot.inverse * pivot.U.n;
  body.I.subtract(n, pivot.U.n);
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) body.H(i, j) -= n[i] * pivot.U.f[j];
  body.bias.n += pivot.rest * n;
}

/// Eliminates the coordinates of a step one after the other. `acceleration`: of a drive, else null. Returns
/// false if a coordinate meets negligible inertia.
template <class Kind, class T, class Armature>
bool release_step(const Armature& armature, const T* effort, const T* given, const T* acceleration,
                  bool at_root, PivotOf<T>* pivots, ArticulatedBody<T>& body) {
  for (int i = Kind::nv - 1; i >= 0; --i) {
    PivotOf<T>& pivot = pivots[i];
    if (!Kind::rotates && !body.extended)
      pivot.U = {Vector3<T>::Zero(), body.M * pivot.linear};
    else
      find_wrench<Kind>(body, pivot);
    T rest = -power<Kind>(pivot, body.bias);
    if (effort) rest += effort[i];
    if (given && !acceleration) rest += given[i];
    if (acceleration) rest -= armature * acceleration[i];
    pivot.rest = rest;
    if (acceleration) continue;
    const T meets = power<Kind>(pivot, pivot.U) + armature;
    // `entry` is an upper bound of the mass matrix's diagonal entry: a pivot below 1e-14 of that is rounding.
    T entry(0);
    if (Kind::rotates) entry += body.bound.polar_inertia() * pivot.angular.squaredNorm();
    if (Kind::slides) entry += body.bound.mass * pivot.linear.squaredNorm();
    if (!everywhere(meets > 2e-14 * (entry + armature))) return false;
    pivot.inverse = 1 / meets;
    if (!at_root || i > 0) release(pivot, body);
  }
  return true;
}

// ---- outwards: accelerations ----

/// Accelerations a of a pendant's ball. Nothing is carried by a pendant, so its link's acceleration is not
/// stored.
template <class T>
void follow_hanging(bool stays, const LinkOf<T>* before, const PendantOf<T>& pendant, const LinkOf<T>& link,
                    T* a) {
  const Matrix3<T>& R = link.motion.R;
  Vector3<T> angular = link.turning, rates = -link.at_rest;
  if (before) {
    angular += before->angular;
    Vector3<T> linear = before->linear;
    if (!stays) linear += before->angular.cross(link.motion.r);
    rates -= pendant.inverse * pendant.h.cross(Vector3<T>(R.transpose() * linear));
  }
  rates -= R.transpose() * angular;
  for (int i = 0; i < 3; ++i) a[i] = rates[i];
}

/// Acceleration a of a step's coordinates and of its link, from the link before it. `pendant`: read only if
/// the link hangs. `drive_efforts`: of a drive, else null; receives the drive's generalised forces.
template <class Kind, class T>
void follow(bool stays, bool loose, const LinkOf<T>* before, const PivotOf<T>* pivots,
            const PendantOf<T>* pendant, LinkOf<T>& link, T* a, T* drive_efforts) {
  if constexpr (is_lanes<T> && turns_freely<Kind>)
    if (loose && link.hangs) return follow_hanging<T>(stays, before, *pendant, link, a);
  Vector3<T> angular = Vector3<T>::Zero(), linear = Vector3<T>::Zero();
  if (before) {
    angular = before->angular;
    linear = before->linear;
    if (!stays) linear += angular.cross(link.motion.r);
  }
  if (turns_freely<Kind> && loose) {
    angular += link.turning;
    if (link.collapsed) {
      const Vector3<T> unturned = angular;
      angular = -link.at_rest;
      if (before) angular -= link.by_push * linear;
      const Vector3<T> rates = link.motion.R.transpose() * (angular - unturned);
      for (int i = 0; i < Kind::nv; ++i) a[i] = rates[i];
      link.angular = angular;
      link.linear = linear;
      return;
    }
  }
  for (int i = 0; i < Kind::nv; ++i) {
    const PivotOf<T>& pivot = pivots[i];
    const T follows = pivot.U.n.dot(angular) + pivot.U.f.dot(linear);
    if (drive_efforts) {
      drive_efforts[i] = follows - pivot.rest;
      continue;
    }
    const T rate = pivot.inverse * (pivot.rest - follows);
    a[i] = rate;
    if (Kind::rotates) angular += rate * pivot.angular;
    if (Kind::slides) linear += rate * pivot.linear;
  }
  link.angular = angular;
  link.linear = linear;
}

/// Eliminates all coordinates of a step. Returns false if a coordinate meets negligible inertia.
template <class Kind, class T, class Armature>
bool free_step(const Armature& armature, bool loose, const T* effort, const T* given, const T* acceleration,
               bool at_root, PivotOf<T>* pivots, ArticulatedBody<T>& body, LinkOf<T>& link) {
  if constexpr (turns_freely<Kind>) {
    link.collapsed = link.hangs = false;
    if (loose) {
      Vector3<T> torque = Vector3<T>::Zero();
      for (int i = 0; i < 3; ++i) {
        if (effort) torque += effort[i] * link.motion.R.col(i);
        if (given) torque += given[i] * link.motion.R.col(i);
      }
      if (collapse<T>(torque, effort || given, at_root, body, link)) return true;
    }
    for (int i = 0; i < 3; ++i) pivots[i].angular = link.motion.R.col(i);
  }
  return release_step<Kind>(armature, effort, given, acceleration, at_root, pivots, body);
}

}  // namespace borelli::articulated
