// A convex shape prepared for contacts.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/scene/shape.hpp"

namespace borelli {

/// Flat face of a polytope: outward unit normal, corners counter-clockwise seen from outside (indices into
/// Convex::vertices).
struct ConvexFace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  std::vector<int> corners;
};

/// A convex shape in its own frame F: a polytope swollen by `radii.x()`, i.e. all points within that distance
/// of it (box, mesh, capsule, sphere); a cylinder along z; or an ellipsoid.
struct Convex {
  enum class Kind { polytope, cylinder, ellipsoid };
  Kind kind = Kind::polytope;
  Pose X_SF;                                        ///< in its solid
  Eigen::Vector3d radii = Eigen::Vector3d::Zero();  ///< half axes; x: radius of a cylinder or swelling; m
  double half = 0;                                  ///< half length of a cylinder, m
  std::vector<Eigen::Vector3d> vertices;            ///< of the polytope, m
  std::vector<ConvexFace> faces;                    ///< none: a point or a segment
  std::vector<std::vector<int>> neighbours;         ///< per vertex: the other ends of its edges
  std::vector<Eigen::Vector3d> edges;  ///< unit directions of the edges, each once; none if there are over 12
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the bounding and the inscribed sphere
  double bound = 0, inscribed = 0;                   ///< their radii, m

  /// The farthest point in direction d.
  Eigen::Vector3d support(const Eigen::Vector3d& d) const;
  /// Index of the farthest vertex in direction d.
  int farthest_vertex(const Eigen::Vector3d& d) const;
};

/// Why the shape cannot be in a contact; empty: it can.
std::string convex_complaint(const Shape& shape);

/// Requires a shape without complaint.
std::shared_ptr<const Convex> make_convex(const Shape& shape);

/// Number of contacts that a shape may need: sphere and ellipsoid one, capsule two, others eight.
int most_contacts(const Form& form);

}  // namespace borelli
