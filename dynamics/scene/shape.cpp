#include "dynamics/scene/shape.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

// Volume, centre and central second moments per volume (the matrix of means of x x^T), in the form's own
// frame.
struct Moments {
  double volume = 0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d spread = Matrix3d::Zero();
};

template <class... F>
struct overloaded : F... {
  using F::operator()...;
};
template <class... F>
overloaded(F...) -> overloaded<F...>;

// ---- primitives ----

Moments moments_of(const Box& box) {
  return {box.size.prod(), Vector3d::Zero(), (box.size.cwiseAbs2() / 12).asDiagonal()};
}

Moments moments_of(const Ellipsoid& e) {
  return {4 * pi / 3 * e.radii.prod(), Vector3d::Zero(), (e.radii.cwiseAbs2() / 5).asDiagonal()};
}

Moments moments_of(const Sphere& s) { return moments_of(Ellipsoid{Vector3d::Constant(s.radius)}); }

Moments moments_of(const Cylinder& c) {
  const double rr = c.radius * c.radius;
  return {pi * rr * c.length, Vector3d::Zero(),
          Vector3d(rr / 4, rr / 4, c.length * c.length / 12).asDiagonal()};
}

Moments moments_of(const Cone& c) {
  const double rr = c.radius * c.radius, ll = c.length * c.length;
  return {pi * rr * c.length / 3, Vector3d(0, 0, c.length / 4),
          Vector3d(3 * rr / 20, 3 * rr / 20, 3 * ll / 80).asDiagonal()};
}

Moments moments_of(const Capsule& c) {
  const double r = c.radius, l = c.length;
  const double tube = pi * r * r * l, caps = 4 * pi / 3 * r * r * r, volume = tube + caps;
  // the centroid of a half sphere lies 3/8 r above its base, which lies l/2 from the middle
  const double across = (tube * r * r / 4 + caps * r * r / 5) / volume;
  const double along = (tube * l * l / 12 + caps * (r * r / 5 + l * l / 4 + 3 * l * r / 8)) / volume;
  return {volume, Vector3d::Zero(), Vector3d(across, across, along).asDiagonal()};
}

// ---- mesh ----

struct ByCoordinates {
  bool operator()(const Vector3d& a, const Vector3d& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  }
};

std::string at(const Vector3d& p) { return fmt::format("({:g}, {:g}, {:g})", p.x(), p.y(), p.z()); }

std::optional<Error> check_indices(const ClosedMesh& mesh) {
  const auto complain = [](std::string what) { return Error{"mesh", std::move(what), Error::Kind::use}; };
  if (mesh.triangles.empty()) return complain("has no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite()) return complain(fmt::format("vertex {} is not finite", i));
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t])
      if (v < 0 || v >= count)
        return complain(
            fmt::format("triangle {} refers to vertex {}; vertices run from 0 to {}", t, v, count - 1));
  return std::nullopt;
}

// Merges vertices with equal coordinates and drops triangles that degenerate by it.
ClosedMesh welded(const ClosedMesh& mesh) {
  ClosedMesh out;
  std::map<Vector3d, int, ByCoordinates> seen;
  std::vector<int> number;
  for (const Vector3d& p : mesh.vertices) {
    const auto [it, is_new] = seen.emplace(p, static_cast<int>(out.vertices.size()));
    if (is_new) out.vertices.push_back(p);
    number.push_back(it->second);
  }
  for (const auto& t : mesh.triangles) {
    const std::array<int, 3> u{number[t[0]], number[t[1]], number[t[2]]};
    if (u[0] != u[1] && u[1] != u[2] && u[2] != u[0]) out.triangles.push_back(u);
  }
  return out;
}

// Every edge must be traversed equally often in both directions. Then the triangles bound a solid, and
// integrals over them do not depend on the inner point.
std::optional<Error> check_closed(const ClosedMesh& mesh) {
  std::map<std::pair<int, int>, std::pair<int, int>>
      runs;  // edge (low, high) -> times traversed up, times down
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      auto& [up, down] = runs[{std::min(a, b), std::max(a, b)}];
      ++(a < b ? up : down);
    }
  for (const auto& [edge, run] : runs) {
    if (run.first == run.second) continue;
    const std::string from = at(mesh.vertices[edge.first]), to = at(mesh.vertices[edge.second]);
    const bool even = (run.first + run.second) % 2 == 0;
    return Error{"mesh",
                 even
                     ? fmt::format("neighbouring triangles have opposite orientations at the edge from {} to "
                                   "{}; orient all of them counter-clockwise seen from outside",
                                   from, to)
                     : fmt::format("is not closed: {} triangle(s) meet at the edge from {} to {}, expected 2",
                                   run.first + run.second, from, to),
                 Error::Kind::use};
  }
  return std::nullopt;
}

// The shells of a mesh: for each triangle the number of its connected component, from 0.
std::vector<int> shells(const ClosedMesh& mesh, int& count) {
  std::vector<int> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) root[find(t[0])] = root[find(t[1])] = find(t[2]);
  std::map<int, int> number;
  std::vector<int> shell;
  for (const auto& t : mesh.triangles)
    shell.push_back(number.emplace(find(t[0]), static_cast<int>(number.size())).first->second);
  count = static_cast<int>(number.size());
  return shell;
}

// Winding number about p of all shells but `without`: the sum of the solid angles of their triangles over 4
// pi (Van Oosterom & Strackee 1983, IEEE Trans Biomed Eng 30:125).
double winding(const ClosedMesh& mesh, const std::vector<int>& shell, int without, const Vector3d& p) {
  double angle = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (shell[t] == without) continue;
    const Vector3d a = mesh.vertices[mesh.triangles[t][0]] - p, b = mesh.vertices[mesh.triangles[t][1]] - p,
                   c = mesh.vertices[mesh.triangles[t][2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4 * pi);
}

// Shells oriented outwards must lie outside all others, shells oriented inwards (cavities) inside another.
// Otherwise material would count twice or negatively.
std::optional<Error> check_shells(const ClosedMesh& mesh, const Vector3d& inner) {
  int count = 0;
  const std::vector<int> shell = shells(mesh, count);
  std::vector<double> volume(count, 0);
  std::vector<int> first(count, -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const Vector3d a = mesh.vertices[tri[0]] - inner, b = mesh.vertices[tri[1]] - inner,
                   c = mesh.vertices[tri[2]] - inner;
    volume[shell[t]] += a.dot(b.cross(c)) / 6;
    if (first[shell[t]] < 0) first[shell[t]] = tri[0];
  }
  for (int s = 0; s < count; ++s) {
    const Vector3d& p = mesh.vertices[first[s]];
    const double wraps = count > 1 ? winding(mesh, shell, s, p) : 0;
    if (volume[s] > 0 && wraps > 0.75)
      return Error{"mesh",
                   fmt::format("the shell at {} lies inside another one, and both face outwards", at(p)),
                   Error::Kind::use};
    if (volume[s] < 0 && wraps < 0.25)
      return Error{"mesh",
                   fmt::format("faces inwards at {} (signed volume {:g} m^3); orient its triangles "
                               "counter-clockwise seen from outside",
                               at(p), volume[s]),
                   Error::Kind::use};
  }
  return std::nullopt;
}

Result<Moments> moments_of(const ClosedMesh& raw) {
  if (auto error = check_indices(raw)) return tl::unexpected(*error);
  const ClosedMesh mesh = welded(raw);
  if (mesh.triangles.empty()) return bad_use("mesh", "has no triangles that enclose a volume");
  if (auto error = check_closed(mesh)) return tl::unexpected(*error);

  // an inner point near the middle avoids cancellation for a solid far from the origin
  Vector3d low = mesh.vertices[mesh.triangles[0][0]], high = low;
  for (const auto& t : mesh.triangles)
    for (const int v : t) {
      low = low.cwiseMin(mesh.vertices[v]);
      high = high.cwiseMax(mesh.vertices[v]);
    }
  const Vector3d inner = 0.5 * (low + high);
  if (auto error = check_shells(mesh, inner)) return tl::unexpected(*error);

  Moments m;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.vertices[t[0]] - inner, b = mesh.vertices[t[1]] - inner,
                   c = mesh.vertices[t[2]] - inner;
    const double v = a.dot(b.cross(c)) / 6;  // of the tetrahedron (inner, a, b, c)
    const Vector3d sum = a + b + c;
    m.volume += v;
    first += v / 4 * sum;
    second += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  // rounding of the volume of a flat mesh stays far below this share of the cube around it
  const double around = std::pow((high - low).norm(), 3);
  if (!(m.volume > 1e-13 * around))
    return bad_use("mesh", fmt::format("encloses no volume (signed volume {:g} m^3)", m.volume));
  const Vector3d middle = first / m.volume;
  m.centre = inner + middle;
  m.spread = second / m.volume - middle * middle.transpose();
  return m;
}

// ---- all forms ----

std::optional<Error> check_sizes(const char* form,
                                 std::initializer_list<std::pair<const char*, double>> sizes) {
  for (const auto& [name, value] : sizes)
    if (!(value > 0) || !std::isfinite(value))
      return Error{form, fmt::format("{} is {:g}, expected a positive number of metres", name, value),
                   Error::Kind::use};
  return std::nullopt;
}

template <class Primitive>
Result<Moments> checked(const Primitive& p, const char* name,
                        std::initializer_list<std::pair<const char*, double>> sizes) {
  if (auto error = check_sizes(name, sizes)) return tl::unexpected(*error);
  return moments_of(p);
}

Result<Moments> moments_of(const Form& form) {
  return std::visit(
      overloaded{[](const Box& b) {
                   return checked(b, "box",
                                  {{"size[0]", b.size[0]}, {"size[1]", b.size[1]}, {"size[2]", b.size[2]}});
                 },
                 [](const Sphere& s) {
                   return checked(s, "sphere", {{"radius", s.radius}});
                 },
                 [](const Cylinder& c) {
                   return checked(c, "cylinder", {{"radius", c.radius}, {"length", c.length}});
                 },
                 [](const Ellipsoid& e) {
                   return checked(
                       e, "ellipsoid",
                       {{"radii[0]", e.radii[0]}, {"radii[1]", e.radii[1]}, {"radii[2]", e.radii[2]}});
                 },
                 [](const Cone& c) {
                   return checked(c, "cone", {{"radius", c.radius}, {"length", c.length}});
                 },
                 [](const Capsule& c) {
                   return checked(c, "capsule", {{"radius", c.radius}, {"length", c.length}});
                 },
                 [](const ClosedMesh& m) { return moments_of(m); }},
      form);
}

Inertial placed(const Moments& m, const Shape& shape, double mass) {
  const Matrix3d R_SF = shape.orientation.toRotationMatrix();
  const Matrix3d about_centre = mass * (m.spread.trace() * Matrix3d::Identity() - m.spread);
  Inertial inertial;
  inertial.mass = mass;
  inertial.centre = shape.position + R_SF * m.centre;
  inertial.tensor = R_SF * about_centre * R_SF.transpose();
  inertial.tensor = (0.5 * (inertial.tensor + inertial.tensor.transpose())).eval();
  return inertial;
}

std::optional<Error> check_placement(const Shape& shape) {
  if (!shape.position.allFinite()) return Error{"shape", "its position is not finite", Error::Kind::use};
  const double norm = shape.orientation.norm();
  if (!(std::abs(norm - 1) < 1e-9))
    return Error{"shape", fmt::format("its orientation has length {:g}, expected a unit quaternion", norm),
                 Error::Kind::use};
  return std::nullopt;
}

}  // namespace

Result<Inertial> inertial_of_density(const Shape& shape, double density) {
  if (!(density > 0) || !std::isfinite(density))
    return bad_use("density", fmt::format("is {:g}, expected a positive number of kg/m^3", density));
  if (auto error = check_placement(shape)) return tl::unexpected(*error);
  return moments_of(shape.form).map([&](const Moments& m) { return placed(m, shape, density * m.volume); });
}

Result<Inertial> inertial_of_mass(const Shape& shape, double mass) {
  if (!(mass > 0) || !std::isfinite(mass))
    return bad_use("mass", fmt::format("is {:g}, expected a positive number of kg", mass));
  if (auto error = check_placement(shape)) return tl::unexpected(*error);
  return moments_of(shape.form).map([&](const Moments& m) { return placed(m, shape, mass); });
}

}  // namespace borelli
