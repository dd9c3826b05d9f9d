// Primitive shapes of even density and their inertial elements, so that a scene may say "a box of wood" where
// it has no table. The paper calls these its homogeneous geometrical objects.
//
// Closed forms of the primitives; a mesh by exact polynomial integrals over the signed tetrahedra that its
// triangles span with an inner point (Lien & Kajiya 1984, IEEE Computer Graphics and Applications 4(10):35).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <variant>
#include <vector>

#include "error/error.hpp"
#include "inertia/inertial.hpp"

namespace borelli {

/// Centred on the origin, edges along the axes.
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< edge lengths along x, y, z, m
};

/// Centred on the origin.
struct Sphere {
  double radius = 0;  ///< m
};

/// Centred on the origin, along z.
struct Cylinder {
  double radius = 0;  ///< m
  double length = 0;  ///< m
};

/// Centred on the origin.
struct Ellipsoid {
  Eigen::Vector3d radii = Eigen::Vector3d::Zero();  ///< half axes along x, y, z, m
};

/// Base disc centred on the origin in the plane z = 0, tip at z = length.
struct Cone {
  double radius = 0;  ///< of the base, m
  double length = 0;  ///< m
};

/// A cylinder along z, centred on the origin, with a half sphere at either end.
struct Capsule {
  double radius = 0;  ///< m
  double length = 0;  ///< of the cylinder without its caps, m
};

/// A solid bounded by triangles whose vertices turn counter-clockwise seen from outside. Vertices at the very
/// same point count as one, so a triangle soup (STL) is as good as an indexed mesh (OBJ). Several shells and
/// inner cavities are fine.
struct ClosedMesh {
  std::vector<Eigen::Vector3d> vertices;      ///< #V points, m
  std::vector<std::array<int, 3>> triangles;  ///< #T indices into vertices, from 0
};

using Form = std::variant<Box, Sphere, Cylinder, Ellipsoid, Cone, Capsule, ClosedMesh>;

/// A form and where it sits in its solid S: the form's frame F in S.
struct Shape {
  Form form;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< p_SF, m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< R_SF, unit
};

/// Inertial elements of a shape filled with an even density (kg/m^3), in the solid's frame. Refuses sizes and
/// densities that are not positive and finite, and meshes that are not closed, not turned outwards, or whose
/// shells overlap; the error's `where` is the form's name. (A shell that crosses itself is not noticed.)
Result<Inertial> inertial_of_density(const Shape& shape, double density);

/// The same for a given whole mass (kg).
Result<Inertial> inertial_of_mass(const Shape& shape, double mass);

}  // namespace borelli
