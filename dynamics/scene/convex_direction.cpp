#include "dynamics/scene/convex_direction.hpp"

#include <fcl/narrowphase/detail/convexity_based_algorithm/gjk_libccd.h>

#include <algorithm>
#include <cmath>
#include <exception>

namespace borelli {

using Eigen::Vector3d;

namespace {

// The copies are smaller by this share of the radius of the inscribed sphere. Swollen points and segments
// lose all their swelling.
constexpr double smaller = 0.1;
constexpr unsigned most_iterations = 200;
constexpr double distance_tolerance = 1e-7;  // the library's own is 1e-6

struct PlacedCopy {
  const Convex* convex;
  Pose X;
  double unit;  // the library's, m
};

// libccd's support function of a copy.
void support_of_copy(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& [convex, X, unit] = *static_cast<const PlacedCopy*>(object);
  const Convex& c = *convex;
  const Vector3d d = X.R.transpose() * Vector3d(direction->v[0], direction->v[1], direction->v[2]);
  const double less = smaller * c.inscribed;
  Vector3d p = Vector3d::Zero();
  if (c.kind == Convex::Kind::ellipsoid) {
    const Vector3d radii = c.radii.array() - less, scaled = radii.cwiseProduct(d);
    if (const double length = scaled.norm(); length > 0) p = radii.cwiseProduct(scaled) / length;
  } else if (c.kind == Convex::Kind::cylinder) {
    const double across = std::hypot(d.x(), d.y()), r = across > 0 ? (c.radii.x() - less) / across : 0;
    p = {r * d.x(), r * d.y(), d.z() < 0 ? less - c.half : c.half - less};
  } else {
    p = c.vertices[std::size_t(c.farthest_vertex(d))];
    if (!c.faces.empty()) p = c.centre + (1 - smaller) * (p - c.centre);
  }
  const Vector3d p_W = (X * p) / unit;
  for (int i = 0; i < 3; ++i) out->v[i] = p_W[i];
}

}  // namespace

std::optional<Vector3d> direction_between(const Convex& a, const Pose& X_a, const Convex& b,
                                          const Pose& X_b) {
  // The library's tolerances are absolute. For shapes of kilometres its assertions may end the program, so it
  // gets such lengths in a larger unit.
  constexpr double largest = 100;  // in its unit of length
  const double size = std::max(X_a.p.norm() + a.bound, X_b.p.norm() + b.bound);
  if (!std::isfinite(size)) return std::nullopt;
  const double unit = std::max(1.0, size / largest);
  // A shape that is thinner than the tolerance has a flat polytope, which the library does not take either.
  const auto is_flat = [&](const Convex& c) {
    const bool solid = c.kind != Convex::Kind::polytope || !c.faces.empty();
    return solid && c.inscribed < 10 * distance_tolerance * unit;
  };
  if (unit > 1 && (is_flat(a) || is_flat(b))) return std::nullopt;
  PlacedCopy copy_a{&a, X_a, unit}, copy_b{&b, X_b, unit};
  double distance = 0;
  Vector3d on_a, on_b;
  try {
    fcl::detail::GJKSignedDistance<double>(&copy_a, support_of_copy, &copy_b, support_of_copy,
                                           most_iterations, distance_tolerance, &distance, &on_a, &on_b);
  } catch (const std::exception&) {  // (it throws where its own search degenerates)
    return std::nullopt;
  }
  const Vector3d d = distance < 0 ? Vector3d(on_b - on_a) : Vector3d(on_a - on_b);
  const double length = d.norm();
  if (!(length > 0) || !d.allFinite()) return std::nullopt;
  return d / length;
}

}  // namespace borelli
