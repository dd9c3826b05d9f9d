#include "dynamics/scene/convex.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/scene/constraint_convex_over_convex.hpp"
#include "dynamics/scene/constraint_convex_over_plane.hpp"
#include "dynamics/scene/convex_hull.hpp"

namespace borelli {

using Eigen::Vector3d;

namespace {

// Relative to the size: triangles of a hull whose planes agree this closely make one face.
constexpr double same_plane = 1e-7;

void add_box(const Box& box, Convex& out) {
  for (int k = 0; k < 8; ++k)
    out.vertices.push_back(
        Vector3d(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5).cwiseProduct(box.size));
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      ConvexFace& face = out.faces.emplace_back();
      face.normal = (side ? 1. : -1.) * Vector3d::Unit(axis);
      const int x = 1 << (axis + 1) % 3, y = 1 << (axis + 2) % 3, on = side << axis;
      face.corners =
          side ? std::vector{on, on | x, on | x | y, on | y} : std::vector{on, on | y, on | x | y, on | x};
    }
}

// The corners of the face in the plane of a triangle, in order.
std::vector<int> corners_on(const std::vector<Vector3d>& vertices, const Vector3d& normal, double height,
                            double tolerance) {
  std::vector<int> out;
  Vector3d middle = Vector3d::Zero();
  for (int v = 0; v < int(vertices.size()); ++v)
    if (normal.dot(vertices[std::size_t(v)]) > height - tolerance) {
      out.push_back(v);
      middle += vertices[std::size_t(v)];
    }
  middle /= double(out.size());
  const Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  const auto angle = [&](int v) {
    const Vector3d d = vertices[std::size_t(v)] - middle;
    return std::atan2(d.dot(y), d.dot(x));
  };
  std::sort(out.begin(), out.end(), [&](int a, int b) { return angle(a) < angle(b); });
  return out;
}

void add_hull(const ClosedMesh& mesh, Convex& out) {
  const ClosedMesh hull = *convex_hull(mesh.vertices);
  std::vector<int> number(hull.vertices.size(), -1);
  for (const auto& triangle : hull.triangles)
    for (const int v : triangle)
      if (int& n = number[std::size_t(v)]; n < 0) {
        n = int(out.vertices.size());
        out.vertices.push_back(hull.vertices[std::size_t(v)]);
      }
  double size = 0;
  for (const Vector3d& v : out.vertices) size = std::max(size, (v - out.vertices[0]).norm());
  for (const auto& triangle : hull.triangles) {
    const Vector3d a = hull.vertices[std::size_t(triangle[0])], b = hull.vertices[std::size_t(triangle[1])],
                   c = hull.vertices[std::size_t(triangle[2])];
    const Vector3d n = (b - a).cross(c - a);
    if (!(n.norm() > 1e-12 * size * size)) continue;  // (a sliver of coplanar points)
    const Vector3d normal = n.normalized();
    const auto same = [&](const ConvexFace& face) { return (face.normal - normal).norm() < same_plane; };
    if (std::any_of(out.faces.begin(), out.faces.end(), same)) continue;
    out.faces.push_back({normal, corners_on(out.vertices, normal, normal.dot(a), same_plane * size)});
  }
}

void find_neighbours(Convex& out) {
  out.neighbours.resize(out.vertices.size());
  for (const ConvexFace& face : out.faces)
    for (std::size_t i = 0; i < face.corners.size(); ++i) {
      const int a = face.corners[i], b = face.corners[(i + 1) % face.corners.size()];
      auto& of_a = out.neighbours[std::size_t(a)];
      auto& of_b = out.neighbours[std::size_t(b)];
      if (std::find(of_a.begin(), of_a.end(), b) == of_a.end()) of_a.push_back(b);
      if (std::find(of_b.begin(), of_b.end(), a) == of_b.end()) of_b.push_back(a);
    }
}

// Finds the directions of the edges. A shape with more than `most` gets none: for it touch_of compares the
// faces and the edges near the direction found.
void find_edges(Convex& out) {
  constexpr std::size_t most = 12;
  for (std::size_t a = 0; a < out.vertices.size(); ++a)
    for (const int b : out.neighbours[a]) {
      const Vector3d edge = (out.vertices[std::size_t(b)] - out.vertices[a]).normalized();
      const auto same = [&](const Vector3d& e) { return e.cross(edge).norm() < same_plane; };
      if (std::any_of(out.edges.begin(), out.edges.end(), same)) continue;
      if (out.edges.size() == most) return out.edges.clear();
      out.edges.push_back(edge);
    }
}

// The spheres about the centroid of the vertices.
void find_spheres(Convex& out) {
  for (const Vector3d& v : out.vertices) out.centre += v / double(out.vertices.size());
  for (const Vector3d& v : out.vertices) out.bound = std::max(out.bound, (v - out.centre).norm());
  out.inscribed = out.faces.empty() ? 0 : std::numeric_limits<double>::infinity();
  for (const ConvexFace& face : out.faces)
    out.inscribed =
        std::min(out.inscribed, face.normal.dot(out.vertices[std::size_t(face.corners[0])] - out.centre));
  out.bound += out.radii.x();
  out.inscribed += out.radii.x();
}

int contacts_of_pair(const Form& a, const Form& b) { return std::min(most_contacts(a), most_contacts(b)); }

}  // namespace

int most_contacts(const Form& form) {
  if (std::holds_alternative<Sphere>(form) || std::holds_alternative<Ellipsoid>(form)) return 1;
  return std::holds_alternative<Capsule>(form) ? 2 : 8;
}

std::string convex_complaint(const Shape& shape) {
  if (std::holds_alternative<Cone>(shape.form)) return "a cone cannot be in a contact; give its mesh";
  if (const auto* mesh = std::get_if<ClosedMesh>(&shape.form)) {
    if (const auto hull = convex_hull(mesh->vertices); !hull) return hull.error().message();
  } else if (const auto fine = inertial_of_mass(shape, 1); !fine) {
    return fine.error().message();
  }
  return "";
}

std::shared_ptr<const Convex> make_convex(const Shape& shape) {
  auto out = std::make_shared<Convex>();
  out->X_SF = {shape.orientation.toRotationMatrix(), shape.position};
  if (const auto* ellipsoid = std::get_if<Ellipsoid>(&shape.form)) {
    out->kind = Convex::Kind::ellipsoid;
    out->radii = ellipsoid->radii;
    out->bound = out->radii.maxCoeff();
    out->inscribed = out->radii.minCoeff();
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape.form)) {
    out->kind = Convex::Kind::cylinder;
    out->radii.setConstant(cylinder->radius);
    out->half = cylinder->length / 2;
    out->bound = std::hypot(cylinder->radius, out->half);
    out->inscribed = std::min(cylinder->radius, out->half);
  } else {
    if (const auto* sphere = std::get_if<Sphere>(&shape.form)) {
      out->radii.setConstant(sphere->radius);
      out->vertices = {Vector3d::Zero()};
    } else if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
      out->radii.setConstant(capsule->radius);
      out->vertices = {Vector3d(0, 0, -capsule->length / 2), Vector3d(0, 0, capsule->length / 2)};
    } else if (const auto* box = std::get_if<Box>(&shape.form)) {
      add_box(*box, *out);
    } else if (const auto* mesh = std::get_if<ClosedMesh>(&shape.form)) {
      add_hull(*mesh, *out);
    }
    find_neighbours(*out);
    if (out->vertices.size() == 2) out->neighbours = {{1}, {0}};
    find_edges(*out);
    find_spheres(*out);
  }
  return out;
}

int Convex::farthest_vertex(const Vector3d& d) const {
  int best = 0;
  double most = d.dot(vertices[0]);
  for (int v = 1; v < int(vertices.size()); ++v)
    if (const double along = d.dot(vertices[std::size_t(v)]); along > most) {
      most = along;
      best = v;
    }
  return best;
}

Vector3d Convex::support(const Vector3d& d) const {
  if (kind == Kind::ellipsoid) {
    const Vector3d scaled = radii.cwiseProduct(d);
    return radii.cwiseProduct(scaled) / scaled.norm();
  }
  if (kind == Kind::cylinder) {
    const double across = std::hypot(d.x(), d.y()), r = across > 0 ? radii.x() / across : 0;
    return {r * d.x(), r * d.y(), d.z() < 0 ? -half : half};
  }
  return vertices[std::size_t(farthest_vertex(d))] + radii.x() * d.normalized();
}

// ---- the constraints ----

std::string ConvexOverConvex::complaint() const {
  if (std::string bad = convex_complaint(shape_a); !bad.empty()) return "its shape_a: " + bad;
  if (std::string bad = convex_complaint(shape_b); !bad.empty()) return "its shape_b: " + bad;
  return surface.complaint();
}

void ConvexOverConvex::prepare() {
  convex_a = make_convex(shape_a);
  convex_b = make_convex(shape_b);
}

double ConvexOverConvex::inscribed() const {
  return convex_a ? convex_a->inscribed + convex_b->inscribed : 0;
}

int ConvexOverConvex::rows() const { return contact_rows * contacts_of_pair(shape_a.form, shape_b.form); }

std::string ConvexOverPlane::complaint() const {
  if (std::string bad = plane.complaint(); !bad.empty()) return bad;
  if (std::string bad = convex_complaint(shape); !bad.empty()) return "its shape: " + bad;
  return surface.complaint();
}

void ConvexOverPlane::prepare() { prepared = make_convex(shape); }

int ConvexOverPlane::rows() const { return contact_rows * most_contacts(shape.form); }

}  // namespace borelli
