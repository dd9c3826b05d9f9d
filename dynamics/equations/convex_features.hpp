// Vertices, edges, faces and round parts of convex shapes: what meets in a contact.
#pragma once

#include <array>

#include "dynamics/equations/convex_touch.hpp"

namespace borelli {

/// A shape at its place in the world. `side`: 1 or -1: its outward normal is `side` times that of the
/// contact.
struct PlacedConvex {
  const Convex* convex;
  Pose X;  ///< X_WF
  double side;

  Eigen::Vector3d local(const Eigen::Vector3d& n) const { return X.R.transpose() * (side * n); }
  /// The point farthest along the outward normal, world.
  Eigen::Vector3d support(const Eigen::Vector3d& n) const { return X * convex->support(local(n)); }
};

/// A part of a surface where a contact may lie.
struct ConvexFeature {
  int vertex = -1;                                   ///< of a polytope
  bool flank = false;                                ///< of a cylinder: its side, not its rim
  Eigen::Vector3d line = Eigen::Vector3d::Zero();    ///< world direction of an edge or flank; zero: none
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< of the edge, world
  double half = 0;                                   ///< half length of the edge or flank, m
};

/// The parts near the farthest point along the normal: at most 16.
struct NearFeatures {
  std::array<ConvexFeature, 16> all;
  int count = 0;
  void add(const ConvexFeature& feature) {
    if (count < int(all.size())) all[std::size_t(count++)] = feature;
  }
};
/// n: the contact's normal, unit, world.
NearFeatures features_near(const PlacedConvex& shape, const Eigen::Vector3d& n);

/// The point of a part farthest along the normal, world. On a line: at its middle.
Eigen::Vector3d point_of(const PlacedConvex& shape, const ConvexFeature& feature, const Eigen::Vector3d& n);

/// ConvexTouch::roundness of a part.
Eigen::Matrix3d roundness_of(const PlacedConvex& shape, const ConvexFeature& feature,
                             const Eigen::Vector3d& n);

/// A convex polygon in space, at most 48 corners; on the surface of a shape.
struct ConvexPolygon {
  std::array<ConvexPoint, 48> corners;  ///< (without gaps)
  int count = 0;
  void add(const Eigen::Vector3d& p, bool rolls = false) {
    if (count < int(corners.size())) corners[std::size_t(count++)] = {.used = true, .rolls = rolls, .p = p};
  }
};

/// The part of a surface that may touch a plane with this normal: a face, an end, a line or a point. Its
/// corners run around the normal.
ConvexPolygon near_polygon(const PlacedConvex& shape, const Eigen::Vector3d& n);

/// Keeps the part of a polygon that lies above (or below) the face of `shape` with the outward normal
/// `side` n; `face`: its index, or for a cylinder 0.
ConvexPolygon clipped(const ConvexPolygon& polygon, const PlacedConvex& shape, int face,
                      const Eigen::Vector3d& n);

}  // namespace borelli
