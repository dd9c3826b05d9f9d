// Mass, gravity centre and inertia tensor of a solid, and their algebra. `dynamics` uses only this header of
// inertia.
//
// The tensor is stored about the gravity centre, where merging and splitting lose no digits: Steiner's term
// then contains only the distance between the two centres (see e.g. Goldstein, Classical Mechanics, section
// 5.3).
#pragma once

#include <Eigen/Core>

#include "error/eigen_layout.hpp"
#include "error/error.hpp"

namespace borelli {

/// Principal moments and axes of a tensor.
struct PrincipalAxes {
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();  ///< ascending, kg m^2
  /// Columns: unit axes of the moments, right-handed. Equal moments leave the axes undetermined; these are
  /// one choice.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

/// The inertial elements of a solid, in some frame F. SI units.
struct Inertial {
  double mass = 0;                                   ///< kg
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< gravity centre p_FC, m
  /// Inertia tensor about the gravity centre, axes of F, kg m^2, as the matrix's entries: Ixy = -integral xy
  /// dm.
  Eigen::Matrix3d tensor = Eigen::Matrix3d::Zero();

  /// The solid after a displacement (m, axes of F).
  Inertial moved(const Eigen::Vector3d& displacement) const;
  /// The solid after a rotation about F's origin; `R` may also be a reflection.
  Inertial rotated(const Eigen::Matrix3d& R) const;
  /// The same solid at the same place, expressed in another frame G; `R_GF` and `p_GF` (m): pose of F in G.
  Inertial expressed_in(const Eigen::Matrix3d& R_GF, const Eigen::Vector3d& p_GF) const;

  /// Inertia tensor about a point of F (m), axes of F, kg m^2 (Huygens-Steiner).
  Eigen::Matrix3d tensor_about(const Eigen::Vector3d& point) const;
  PrincipalAxes principal() const;
  /// Radii of gyration about three axes through the gravity centre, m: sqrt(moment / mass). The columns of
  /// `R_FA` are the axes, in F. NaN without mass.
  Eigen::Vector3d radii_of_gyration(const Eigen::Matrix3d& R_FA = Eigen::Matrix3d::Identity()) const;
};

/// Two disjoint solids as one, both in the same frame.
Inertial operator+(const Inertial& a, const Inertial& b);
/// The remainder of `whole` without `part`, a part of it, both in the same frame. If nothing is left (equal
/// masses), the result is the empty solid.
Inertial operator-(const Inertial& whole, const Inertial& part);
inline Inertial& operator+=(Inertial& a, const Inertial& b) { return a = a + b; }
inline Inertial& operator-=(Inertial& a, const Inertial& b) { return a = a - b; }

/// A solid made of points on a line (a bar) or of one point has moments that are zero.
enum class Extent { solid, may_be_bar_or_point };

/// Whether such a body can exist: numbers finite, mass positive, tensor symmetric and positive definite (with
/// `may_be_bar_or_point` moments may be zero), and no principal moment larger than the sum of the other two.
/// Violations within rounding (1e-12 of the largest moment) pass. The error's sentence gives the offending
/// numbers; its `where` is `name`.
Result<void> check_physical(const Inertial& inertial, std::string name, Extent extent = Extent::solid);

}  // namespace borelli
