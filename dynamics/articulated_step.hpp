// What one step does in each of the three passes of articulated.hpp, compiled for each kind of switch by
// itself; and in those of inverse_dynamics.hpp. Only their sources include this.
#pragma once

#include "dynamics/articulated.hpp"

namespace borelli::articulated {

using Eigen::Matrix3;
using Eigen::Vector3;

/// Whether a switch may turn as it likes about one point, by unit twists along its axes (a ball).
template <class Kind>
constexpr bool turns_freely = requires {
  Kind::turns_freely;
};

// ---- outwards: motion ----

/// Whether nothing resists the ball of a step but what it carries.
template <class Kind>
bool is_loose(const Parameters& parameters, const Step& step, int s) {
  return turns_freely<Kind> && step.drive < 0 && parameters.armatures[s] == 0;
}

template <class T, class Where>
void place(const Where& placement, PoseOf<T>& X) {
  if (placement.form == Placement::Form::identity) return;
  X.p = X.R * placement.X.p;
  if (placement.form == Placement::Form::general) X.R = X.R * placement.X.R;
}

/// The motion after a step with positions q and velocities u, from that before it (null: the world's);
/// `acceleration` of a drive or where it is given, else null. Its unit twists go to the pivots, but for a
/// ball; of a loose one, `turning` tells what it would do without acceleration.
template <class Kind, class Where, class T>
LinkMotion<T> move(const Kind& kind, const Where& placement, bool loose, const LinkMotion<T>* before,
                   const T* q, const T* u, const T* acceleration, PivotOf<T>* pivots, Vector3<T>& turning) {
  LinkMotion<T> to;
  PoseOf<T> X;  // with the origin of the frame before for the world's: no digits are lost far away
  if (before) {
    X.R = before->R;
    place(placement, X);
  } else {
    X.R = placement.X.R.template cast<T>();
    X.p = placement.X.p.template cast<T>();
  }
  Vector3<T> angular[Kind::nv + 1], linear[Kind::nv + 1];
  kind.advance(q, X, angular, linear);
  to.R = X.R;
  to.r = X.p;
  Vector3<T> w = Vector3<T>::Zero(), v = Vector3<T>::Zero();  // of the step itself
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

/// The place after a step with velocities u, from the link before it (null: the world).
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

// ---- inwards: what each joint meets ----

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

/// A body by itself, with its inertial force less its weight. `turning`: whether wdot is more than zero.
template <class T, class Inertia>
ArticulatedBody<T> alone(const Inertia& inertial, const Eigen::Vector3d& gravity, const LinkMotion<T>& motion,
                         bool turning) {
  const T mass = inertial.mass;
  const Vector3<T> w = motion.w;
  const Vector3<T> d = motion.R * inertial.centre, wd = w.cross(d);
  const Symmetric3<T> I_W = turned<T>(motion.R, inertial.tensor, has_principal_axes(inertial));
  const Vector3<T> momentum = I_W * w;
  Vector3<T> f = motion.vdot + w.cross(wd) - gravity, n = w.cross(momentum);
  if (turning) {
    f += motion.wdot.cross(d);
    n += I_W * motion.wdot;
  }
  ArticulatedBody<T> out;
  out.bias.f = mass * f;
  out.bias.n = n + d.cross(out.bias.f);
  const Vector3<T> h = mass * d;
  out.I = point_inertia<T>(mass, d);
  out.I += I_W;
  out.H << T(0), -h[2], h[1], h[2], T(0), -h[0], -h[1], h[0], T(0);
  out.M = {mass, T(0), T(0), mass, T(0), mass};
  out.mass = mass;
  out.first = h;
  out.polar = 0.5 * out.I.trace();
  out.extended = true;
  return out;
}

template <class T>
void add(const ArticulatedBody<T>& body, ArticulatedBody<T>& to) {
  to.M += body.M;
  to.bias.f += body.bias.f;
  to.mass += body.mass;
  to.first += body.first;
  to.polar += body.polar;
  if (!body.extended) return;
  to.extended = true;
  to.I += body.I;
  to.H += body.H;
  to.bias.n += body.bias.n;
}

/// Of a body that is not extended: what the ball that has followed has left there.
template <class T>
void flatten(ArticulatedBody<T>& body) {
  body.I = {};
  body.H.setZero();
  body.bias.n.setZero();
}

/// The same body at an origin that is -r away.
template <class T>
ArticulatedBody<T> moved(const ArticulatedBody<T>& link, const Vector3<T>& r) {
  ArticulatedBody<T> to;
  const Symmetric3<T>& M = link.M;
  to.M = M;
  to.bias.f = link.bias.f;
  to.bias.n = r.cross(link.bias.f);
  to.mass = link.mass;
  to.first = link.first + link.mass * r;
  to.polar = link.polar + r.dot(link.first + to.first);
  to.extended = true;
  // H' = H + [r]x M, I' = I - H [r]x + [r]x H'^T
  Matrix3<T>& G = to.H;
  G << r[1] * M.xz - r[2] * M.xy, r[1] * M.yz - r[2] * M.yy, r[1] * M.zz - r[2] * M.yz,
      r[2] * M.xx - r[0] * M.xz, r[2] * M.xy - r[0] * M.yz, r[2] * M.xz - r[0] * M.zz,
      r[0] * M.xy - r[1] * M.xx, r[0] * M.yy - r[1] * M.xy, r[0] * M.yz - r[1] * M.xz;
  if (!link.extended) {
    to.I = {r[1] * G(0, 2) - r[2] * G(0, 1), r[1] * G(1, 2) - r[2] * G(1, 1),
            r[1] * G(2, 2) - r[2] * G(2, 1), r[2] * G(1, 0) - r[0] * G(1, 2),
            r[2] * G(2, 0) - r[0] * G(2, 2), r[0] * G(2, 1) - r[1] * G(2, 0)};
    return to;
  }
  const Matrix3<T>& H = link.H;
  G += H;
  to.bias.n += link.bias.n;
  to.I = {link.I.xx + r[1] * (H(0, 2) + G(0, 2)) - r[2] * (H(0, 1) + G(0, 1)),
          link.I.xy + r[2] * H(0, 0) - r[0] * H(0, 2) + r[1] * G(1, 2) - r[2] * G(1, 1),
          link.I.xz + r[0] * H(0, 1) - r[1] * H(0, 0) + r[1] * G(2, 2) - r[2] * G(2, 1),
          link.I.yy + r[2] * (H(1, 0) + G(1, 0)) - r[0] * (H(1, 2) + G(1, 2)),
          link.I.yz + r[0] * H(1, 1) - r[1] * H(1, 0) + r[2] * G(2, 0) - r[0] * G(2, 2),
          link.I.zz + r[0] * (H(2, 1) + G(2, 1)) - r[1] * (H(2, 0) + G(2, 0))};
  return to;
}

/// Lets a ball follow, with `torque` (world axes) on it: what it carries is then a mass to push. False where
/// it is so thin that this must be done axis by axis. Unless something acts, what is then zero in a body is
/// not set (see flatten): nearly always it is moved next.
template <class T>
bool collapse(const Vector3<T>& torque, bool acted, bool at_root, ArticulatedBody<T>& body, LinkOf<T>& link) {
  const Symmetric3<T>& I = body.I;
  Symmetric3<T> inverse{I.yy * I.zz - I.yz * I.yz, I.xz * I.yz - I.xy * I.zz, I.xy * I.yz - I.xz * I.yy,
                        I.xx * I.zz - I.xz * I.xz, I.xy * I.xz - I.xx * I.yz, I.xx * I.yy - I.xy * I.xy};
  const T determinant = I.xx * inverse.xx + I.xy * inverse.xy + I.xz * inverse.xz;
  // the minors are differences: they lose as many digits as this ratio has
  const T size = I.trace();
  if (!everywhere(determinant > 1e-5 * size * size * size) || !everywhere(size > 1e-8 * body.polar))
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

/// The wrench that gives the body the unit acceleration of a coordinate.
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

/// Lets the coordinate of a pivot follow: takes out of the body what then meets no resistance.
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

/// The coordinates of a step, one after the other; `acceleration` of a drive, else null. False where one
/// meets no inertia to speak of.
template <class Kind, class T>
bool release_step(const T& armature, const T* effort, const T* given, const T* acceleration, bool at_root,
                  PivotOf<T>* pivots, ArticulatedBody<T>& body) {
  for (int i = Kind::nv - 1; i >= 0; --i) {
    PivotOf<T> pivot = pivots[i];
    if (!Kind::rotates && !body.extended)
      pivot.U = {Vector3<T>::Zero(), body.M * pivot.linear};
    else
      find_wrench<Kind>(body, pivot);
    pivot.rest = -power<Kind>(pivot, body.bias);
    if (effort) pivot.rest += effort[i];
    if (acceleration) {
      pivot.rest -= armature * acceleration[i];
      pivots[i] = pivot;
      continue;
    }
    if (given) pivot.rest += given[i];
    const T meets = power<Kind>(pivot, pivot.U) + armature;
    // no less than its entry of the mass matrix; what elimination leaves below 1e-14 of that is rounding
    T entry = armature;
    if (Kind::rotates) entry += body.polar * pivot.angular.squaredNorm();
    if (Kind::slides) entry += body.mass * pivot.linear.squaredNorm();
    if (!everywhere(meets > 2e-14 * entry)) return false;
    pivot.inverse = 1 / meets;
    pivots[i] = pivot;
    if (!at_root || i > 0) release(pivot, body);
  }
  return true;
}

// ---- outwards: accelerations ----

/// `drive_efforts` of a drive, else null.
template <class Kind, class T>
void follow(bool stays, bool loose, const LinkOf<T>* before, const PivotOf<T>* pivots, LinkOf<T>& link, T* a,
            T* drive_efforts) {
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

/// Lets all coordinates of a step follow. False where one meets no inertia to speak of.
template <class Kind, class T>
bool free_step(const T& armature, bool loose, const T* effort, const T* given, const T* acceleration,
               bool at_root, PivotOf<T>* pivots, ArticulatedBody<T>& body, LinkOf<T>& link) {
  if constexpr (turns_freely<Kind>) {
    link.collapsed = false;
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
