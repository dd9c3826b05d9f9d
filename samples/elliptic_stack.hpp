// A closed solid whose cross-sections normal to one axis are ellipses: the only shape in the phantom.
// Ellipsoids, spheres, capsules, cylinders and truncated elliptic cones are stacks of few sections; limbs and
// trunk are stacks of many. Planes may cut a stack, and another stack on the same axis may hollow it.
//
// Its moments are exact up to one smooth integral along the axis, which adaptive Gauss-Kronrod quadrature
// computes to 1e-11 of the solid's size (disc_moments.hpp gives the integrals over cross-sections).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

namespace borelli {

/// Pose of a solid: patient point = origin + axes * local point. The axes are orthonormal, and may be
/// left-handed (mirrored solid).
struct Frame {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  Eigen::Vector3d point(const Eigen::Vector3d& local) const { return origin + axes * local; }
  Eigen::Vector3d local(const Eigen::Vector3d& point) const { return axes.transpose() * (point - origin); }
  Frame then(const Frame& inner) const { return {axes * inner.axes, point(inner.origin)}; }
};

/// The points p with normal . p <= offset (mm); the normal is unit.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset;

  bool holds(const Eigen::Vector3d& p) const { return normal.dot(p) <= offset; }
  HalfSpace other_side() const { return {-normal, -offset}; }
};

/// A given cross-section at `height` along the axis: an ellipse with centre (x, y) and semi-axes a along x, b
/// along y, both reduced by `inset`. All mm.
struct Section {
  double height, x, y, a, b, inset = 0;
};

/// An ellipse with axes along the frame's x and y.
struct Ellipse {
  double x, y, a, b;
};

class EllipticStack {
 public:
  /// Sections in order of height, at least two. Between them every number follows a monotone cubic (Fritsch &
  /// Butland 1984), so nothing overshoots. The ends are flat, or rounded over `low_cap`, `high_cap` mm as
  /// half ellipsoids. Each rounded end is shortened by `tip_inset` mm.
  EllipticStack(Frame frame, std::vector<Section> sections, double low_cap = 0, double high_cap = 0,
                double tip_inset = 0);

  /// The solid without its part beyond a plane (given in the patient frame, like the stack's frame). Throws
  /// std::length_error above most_cuts planes (disc_moments.hpp).
  EllipticStack cut(const HalfSpace& half_space) const;
  EllipticStack cut(const std::vector<HalfSpace>& half_spaces) const;
  /// The solid without `hole`, which must have the same frame and lie inside.
  EllipticStack hollowed(const EllipticStack& hole) const;
  /// The same solid, moved: its frame and cuts were given relative to `frame`.
  EllipticStack moved(const Frame& frame) const;
  /// The same solid, scaled by `factor` about the patient origin.
  EllipticStack scaled(double factor) const;
  /// The solid inset by `depth` mm from this one's wall and rounded ends (cuts stay).
  EllipticStack shrunk(double depth) const;

  bool holds(const Eigen::Vector3d& point) const;
  /// The cross-section at a height between low() and high(), before cuts.
  Ellipse section(double height) const {
    std::size_t piece = 0;
    return section(height, piece);
  }
  /// The same; `piece` caches the index of the lower given section, for the next height nearby.
  Ellipse section(double height, std::size_t& piece) const;
  /// Integral of p pT over the solid, where p = (x, y, z, 1) in the patient frame; mm^3 to mm^5.
  Eigen::Matrix4d moments() const;
  double volume() const { return moments()(3, 3); }

  const Frame& frame() const { return frame_; }
  double low() const { return low_; }
  double high() const { return high_; }
  const std::vector<HalfSpace>& cuts() const { return cuts_; }
  const EllipticStack* hole() const { return hole_.get(); }
  /// Lowest and highest corner of the solid's bounding box, in its own frame.
  const Eigen::Vector3d& box_low() const { return box_low_; }
  const Eigen::Vector3d& box_high() const { return box_high_; }
  /// Position of the box relative to a plane: -1 within the half-space, +1 beyond it, 0 across.
  int side(const HalfSpace& half_space) const;

 private:
  struct Piece {  // between two given heights: value(t) = c0 + c1 t + c2 t^2 + c3 t^3, t = height - from
    double from;
    Eigen::Array<double, 4, 5, Eigen::RowMajor> c;  // row: power; column: x, y, a, b, inset
  };
  Eigen::Matrix4d local_moments() const;  // in the stack's frame, without subtracting the hole
  void fit();                             // pieces and box from the sections
  void bound(const HalfSpace& cut);       // shrinks the box if the cut is normal to one of its edges

  Frame frame_;
  std::vector<Section> sections_;
  double low_cap_, high_cap_, low_, high_;
  std::vector<Piece> pieces_;
  std::vector<HalfSpace> cuts_;
  std::shared_ptr<const EllipticStack> hole_;
  Eigen::Vector3d box_low_, box_high_;
};

/// Orthonormal right-handed axes with z along `axis` and x as close to `x_hint` as possible.
Eigen::Matrix3d axes_along(const Eigen::Vector3d& axis, const Eigen::Vector3d& x_hint);

/// Ellipsoid with semi-axes along the columns of `axes`.
EllipticStack ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& semi_axes,
                        const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity());
/// Ball swept from one point to another.
EllipticStack capsule(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius);
/// Truncated elliptic cone from one point to another with flat ends; `from_semi`, `to_semi`: semi-axes along
/// x_hint and normal to it.
EllipticStack cone(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector2d& from_semi,
                   const Eigen::Vector2d& to_semi, const Eigen::Vector3d& x_hint = Eigen::Vector3d::UnitX());

}  // namespace borelli
