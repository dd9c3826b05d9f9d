// Holonomic constraint: a point stays on a curve fixed in a solid or in the world (a rail, a cam's groove, a
// tendon's path).
#pragma once

#include <Eigen/Eigenvalues>
#include <array>
#include <string_view>
#include <vector>

#include "dynamics/numbers/cubic_spline.hpp"
#include "dynamics/scene/site.hpp"

namespace borelli {

template <class T>
class ConstraintPass;

/// e_i . (p - c(s)) = 0: two rows, m. c(s) is the point of the curve nearest to p; e_1 and e_2 are two
/// directions normal to the curve there. The curve is the natural cubic spline through the points, over chord
/// length; it continues straight beyond its ends. A closed curve is the periodic spline. Where two branches
/// of the curve come close, p must stay nearer to its own. At the given points the third derivative jumps,
/// and with it the rate of the accelerations.
struct PointOnCurve {
  static constexpr std::string_view kind = "point_on_curve";
  SolidPoint point;
  SolidName curve;                       ///< the solid that carries it
  std::vector<Eigen::Vector3d> through;  ///< m, in that solid's frame; at least two, at least three if closed
  bool closed = false;                   ///< the first point follows the last

  // computed by prepare()
  std::array<CubicSpline, 3> path;  ///< x, y and z over chord length
  Eigen::Matrix<double, 3, 2> across =
      Eigen::Matrix<double, 3, 2>::Zero();  ///< the two directions in which the chords spread least

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("point", self.point);
    visit("curve", self.curve);
    visit("through", self.through);
    visit("closed", self.closed);
  }

  std::string complaint() const {
    if (through.size() < (closed ? 3 : 2))
      return closed ? "its curve has too few points; a closed one needs at least three"
                    : "its curve has too few points; it needs at least two";
    for (std::size_t i = closed ? 0 : 1; i < through.size(); ++i)
      if (!((through[i] - through[i > 0 ? i - 1 : through.size() - 1]).norm() > 0))
        return "two successive points of its curve coincide";
    return "";
  }

  /// Builds the spline through the points; called by compile().
  void prepare() {
    std::vector<double> lengths{0};
    std::array<std::vector<double>, 3> places;
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    const std::size_t count = through.size() + (closed ? 1 : 0);
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d& p = through[i % through.size()];
      for (int c = 0; c < 3; ++c) places[c].push_back(p[c]);
      if (i == 0) continue;
      const Eigen::Vector3d chord = p - through[i - 1];
      lengths.push_back(lengths.back() + chord.norm());
      spread += chord * chord.transpose();
    }
    for (int c = 0; c < 3; ++c)
      path[c] = CubicSpline(lengths, places[c], closed ? SplineEnds::periodic : SplineEnds::natural);
    const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
    across = axes.leftCols<2>();
  }

  /// The chord length (m) along the curve at its point nearest to x; x in the frame of the solid that carries
  /// it.
  double length_at(const Eigen::Vector3d& x) const { return nearest(x); }

  static constexpr int rows = 2;
  static constexpr int length_rows = 2;

  // With d = p - c(s), normal to the curve: s' (|c'|^2 - d . c'') = c' . p'. For directions e_i that do not
  // twist about the curve, e_i' . d = 0 and e_i' . p' = -(e_i . c'') s' (c' . p') / |c'|^2.
  template <class T>
  void evaluate(ConstraintPass<T>& pass) const {
    enum { point_site, curve_site };
    using std::sqrt;
    using Vector = Eigen::Vector3<T>;
    const auto p = pass.point(point_site, point.point);
    const auto X = pass.frame(curve_site);
    const Vector w = pass.angular_velocity(curve_site), v_rel = p.v - pass.velocity(curve_site, p.p);
    const Vector x = X.R.transpose() * (p.p - X.p), x_rate = X.R.transpose() * v_rel;
    const auto [c, tangent, bend] = at_length(nearest(x));
    const Vector d = x - c;
    const T speed2 = tangent.squaredNorm(), stretch = speed2 - d.dot(bend);
    if (!(value_of(stretch) > 1e-9 * value_of(speed2))) {
      pass.degenerate(0);
      return;
    }
    const Vector t = tangent / sqrt(speed2);
    const Eigen::Vector3d g = std::abs(across.col(0).dot(values_of(t))) < 0.9 ? across.col(0) : across.col(1);
    const Vector u = g.template cast<T>() - t.dot(g.template cast<T>()) * t;
    const Vector e = u / sqrt(u.squaredNorm());
    const T slide = tangent.dot(x_rate);
    const Vector both[2] = {e, t.cross(e)};
    for (int r = 0; r < 2; ++r) {
      const Vector n = X.R * both[r];
      pass.along(r, point_site, p.p, n);
      pass.along(r, curve_site, p.p, -n);
      pass.residual(r, both[r].dot(d), T(0),
                    -2 * n.dot(w.cross(v_rel)) - both[r].dot(bend) * slide * slide / (stretch * speed2));
    }
  }

 private:
  /// The point of the curve at s and its first two derivatives by s.
  template <class T>
  std::array<Eigen::Vector3<T>, 3> at_length(const T& s) const {
    std::array<Eigen::Vector3<T>, 3> out;
    for (int c = 0; c < 3; ++c) {
      const SplineValue<T> one = path[c](s);
      out[0][c] = one.value;
      out[1][c] = one.slope;
      out[2][c] = one.curvature;
    }
    return out;
  }

  template <class T>
  static Eigen::Vector3d values_of(const Eigen::Vector3<T>& x) {
    return {value_of(x[0]), value_of(x[1]), value_of(x[2])};
  }

  /// The s of the curve point nearest to x: the best of samples at the quarters of each piece, refined by
  /// Newton's method. It carries the derivatives of x.
  template <class T>
  T nearest(const Eigen::Vector3<T>& x) const {
    const Eigen::Vector3d at = values_of(x);
    const std::vector<double>& knots = path[0].knots();
    double s = 0, least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < knots.size(); ++i)
      for (int part = 0; part <= 4; ++part) {
        const double here = knots[i] + part * (knots[i + 1] - knots[i]) / 4;
        const double distance = (at - at_length(here)[0]).squaredNorm();
        if (!(distance < least)) continue;
        least = distance;
        s = here;
      }
    double slope = -1;
    for (int i = 0; i < 50; ++i) {
      const auto [c, tangent, bend] = at_length(s);
      const double full = tangent.squaredNorm(), offset = (at - c).dot(bend);
      slope = -std::max(full - offset, 0.1 * full);  // bounded, so that Newton finds the minimum of the
                                                     // distance, not the maximum
      const double step = -(at - c).dot(tangent) / slope;
      s += step;
      if (std::abs(step) <= 1e-15 * knots.back()) break;
    }
    if constexpr (std::is_same_v<T, double>) return s;
    const auto [c, tangent, bend] = at_length(s);
    const Eigen::Vector3<T> off = x - c.template cast<T>();
    return s + off.dot(tangent.template cast<T>()) / (tangent.squaredNorm() - (at - c).dot(bend));
  }
};

}  // namespace borelli
