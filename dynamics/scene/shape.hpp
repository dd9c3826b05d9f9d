// Homogeneous primitive shapes and their inertias, for scenes without measured ones. The paper calls them
// homogeneous geometrical objects.
//
// Primitives use closed forms. A mesh uses exact polynomial integrals over the signed tetrahedra that its
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

/// A solid bounded by triangles, counter-clockwise seen from outside. Vertices with equal coordinates count
/// as one, so a triangle soup (STL) works like an indexed mesh (OBJ). Several shells and inner cavities are
/// allowed.
struct ClosedMesh {
  std::vector<Eigen::Vector3d> vertices;      ///< #V points, m
  std::vector<std::array<int, 3>> triangles;  ///< #T indices into vertices, from 0
};

using Form = std::variant<Box, Sphere, Cylinder, Ellipsoid, Cone, Capsule, ClosedMesh>;

/// A form and the pose of its frame F in its solid S.
struct Shape {
  Form form;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< p_SF, m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< R_SF, unit
};

/// Inertia of a shape filled with a homogeneous density (kg/m^3), in the frame of the solid. Errors: sizes or
/// densities that are not positive and finite, a placement that is not finite or not unit, and meshes that
/// are not closed, not oriented outwards, or whose shells overlap. `where` of the error names the form,
/// "shape" (placement) or "density". (A shell that intersects itself is not detected.)
Result<Inertial> inertial_of_density(const Shape& shape, double density);

/// The same for a given total mass (kg).
Result<Inertial> inertial_of_mass(const Shape& shape, double mass);

}  // namespace borelli
