// The rows of contacts of convex shapes. The bias needs the rates of the normal and of the contact point.
// They follow from the condition that the normals of both surfaces stay opposite and the nearest points stay
// on their common normal (Montana, The kinematics of contact and grasp, 1988).
#include <Eigen/QR>
#include <algorithm>

#include "dynamics/equations/convex_touch.hpp"
#include "dynamics/equations/passes.hpp"
#include "dynamics/numbers/dual.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Flat = ConvexTouch::Flat;

namespace {

enum { a_site, b_site };

struct TouchRates {
  Vector3d normal, point;  // 1/s, m/s
};

TouchRates rates_of(const ConstraintPass<double>& pass, const ConvexTouch& touch, const ConvexPoint& point) {
  const Vector3d &n = touch.normal, turn_a = pass.angular_velocity(a_site).cross(n),
                 turn_b = pass.angular_velocity(b_site).cross(n);
  const Vector3d v_a = pass.velocity(a_site, point.p), v_b = pass.velocity(b_site, point.p);
  if (touch.flat == Flat::a)
    return {turn_a, point.rolls ? Vector3d(v_b + touch.roundness_b * (turn_a - turn_b)) : v_b};
  if (touch.flat == Flat::b)
    return {turn_b, point.rolls ? Vector3d(v_a - touch.roundness_a * (turn_b - turn_a)) : v_a};
  // unknowns: the normal's rate along two tangents, the rates of the nearest points along the lines
  const Vector3d x = across<double>(n), y = n.cross(x),
                 apart = v_a - pass.velocity(b_site, point.p - point.gap * n);
  const Matrix3d stiff = touch.roundness_a + touch.roundness_b + point.gap * Matrix3d::Identity();
  const Vector3d right = apart + touch.roundness_a * turn_a + touch.roundness_b * turn_b;
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  Eigen::Vector4d known = Eigen::Vector4d::Zero();
  const Vector3d along[2] = {x, y};
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 2; ++c) M(r, c) = along[r].dot(stiff * along[c]);
    M(r, 2) = -along[r].dot(touch.line_a);
    M(r, 3) = along[r].dot(touch.line_b);
    known[r] = along[r].dot(right);
  }
  const Vector3d lines[2] = {touch.line_a, touch.line_b}, turns[2] = {turn_a, turn_b};
  for (int k = 0; k < 2; ++k) {
    if (lines[k].isZero()) {
      M(2 + k, 2 + k) = 1;
      continue;
    }
    for (int c = 0; c < 2; ++c) M(2 + k, c) = lines[k].dot(along[c]);
    known[2 + k] = lines[k].dot(turns[k]);
  }
  const Eigen::Vector4d solved = M.colPivHouseholderQr().solve(known);
  const Vector3d rate = solved[0] * x + solved[1] * y;
  return {rate, v_a - touch.roundness_a * (rate - turn_a) + solved[2] * touch.line_a};
}

/// Three rows per slot. `size`: gap of a slot that is not needed, m. `fastest`: bound on the approach speed.
void rows_of_touch(ConstraintPass<double>& pass, const ConvexTouch& touch, double size, double fastest) {
  using Detail = ConstraintPass<double>::Detail;
  const bool any =
      std::any_of(touch.points.begin(), touch.points.end(), [](const ConvexPoint& p) { return p.used; });
  Eigen::Matrix3d axes;
  axes.col(0) = touch.normal;
  axes.col(1) = across<double>(touch.normal);
  axes.col(2) = touch.normal.cross(axes.col(1));
  for (int k = 0; k < touch.count; ++k) {
    const ConvexPoint& point = touch.points[std::size_t(k)];
    const int r = 3 * k;
    // (shapes too far apart for points may still meet within a step)
    if (pass.detail() != Detail::values) pass.speed(r, point.used || (!any && k == 0) ? fastest : 0);
    if (!point.used) {
      pass.residual(r, any ? size : touch.gap, 0, 0);
      for (int c = 1; c < 3; ++c) pass.residual(r + c, 0, 0, 0);
      continue;
    }
    Meeting<double> at{point.p, Vector3d::Zero(), point.gap};
    Eigen::Matrix3d axes_rate = Eigen::Matrix3d::Zero();
    if (pass.detail() == Detail::rows) {
      const TouchRates rates = rates_of(pass, touch, point);
      at.p_rate = rates.point;
      axes_rate.col(0) = rates.normal;
      for (int c = 1; c < 3; ++c) axes_rate.col(c) = -axes.col(c).dot(rates.normal) * touch.normal;
    }
    slip_rows<double, 3>(pass, r, a_site, b_site, at, axes, axes_rate, point.gap);
  }
}

// Derivatives of these rows by the state are not given: no method that takes contacts of these kinds needs
// them.
void open_rows(ConstraintPass<DualNumber>& pass, int rows) {
  for (int r = 0; r < rows; ++r)
    pass.residual(r, DualNumber(r % 3 == 0 ? 1. : 0.), DualNumber(0), DualNumber(0));
}

void evaluate_pair(const ConvexOverConvex& pair, ConstraintPass<double>& pass) {
  const Convex &a = *pair.convex_a, &b = *pair.convex_b;
  const Pose Xa = pass.frame(a_site) * a.X_SF, Xb = pass.frame(b_site) * b.X_SF;
  const ConvexTouch touch = touch_of(a, Xa, b, Xb, pair.rows() / pair.contact_rows);
  double fastest = 0;
  if (pass.detail() != ConstraintPass<double>::Detail::values) {
    const Vector3d va = pass.velocity(a_site, Xa * a.centre), vb = pass.velocity(b_site, Xb * b.centre);
    fastest = (va - vb).norm() + pass.angular_velocity(a_site).norm() * a.bound +
              pass.angular_velocity(b_site).norm() * b.bound;
  }
  rows_of_touch(pass, touch, a.bound + b.bound, fastest);
}

void evaluate_pair(const ConvexOverPlane& pair, ConstraintPass<double>& pass) {
  const Convex& a = *pair.prepared;
  const Pose X = pass.frame(b_site);
  const ConvexTouch touch =
      touch_of_plane(a, pass.frame(a_site) * a.X_SF, X * pair.plane.on.point, X.R * pair.plane.normal,
                     X.R * across<double>(pair.plane.normal), pair.rows() / pair.contact_rows);
  rows_of_touch(pass, touch, 2 * a.bound, 0);
}

template <class Kind>
void evaluate_pair(const Kind& pair, ConstraintPass<DualNumber>& pass) {
  open_rows(pass, pair.rows());
}

}  // namespace

template <class T>
void ConvexOverConvex::evaluate(ConstraintPass<T>& pass) const {
  evaluate_pair(*this, pass);
}

template <class T>
void ConvexOverPlane::evaluate(ConstraintPass<T>& pass) const {
  evaluate_pair(*this, pass);
}

template void ConvexOverConvex::evaluate(ConstraintPass<double>&) const;
template void ConvexOverConvex::evaluate(ConstraintPass<DualNumber>&) const;
template void ConvexOverPlane::evaluate(ConstraintPass<double>&) const;
template void ConvexOverPlane::evaluate(ConstraintPass<DualNumber>&) const;

}  // namespace borelli
