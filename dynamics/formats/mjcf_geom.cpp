#include "dynamics/formats/mjcf_geom.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "dynamics/formats/mjcf_edit.hpp"
#include "dynamics/formats/mjcf_shell.hpp"
#include "dynamics/formats/triangle_file.hpp"
#include "dynamics/scene/convex_hull.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Sized {
  std::string type;
  Pose X;  // of the form in its body
  std::vector<double> size;
};

// Type, pose and size. `fromto` may replace a part of them: it gives the ends of the z axis of the form.
Sized sized(const XmlElement& geom, const MjcfCompilers& compilers) {
  Sized out;
  out.type = geom.word(
      "type", {"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"},
      "sphere");
  out.X = compilers.pose_of(geom);
  out.size = geom.numbers("size", 1, 3);
  const auto ends = geom.numbers("fromto", 6, 6);
  if (ends.empty()) return out;
  const bool round = out.type == "capsule" || out.type == "cylinder";
  if (!round && out.type != "ellipsoid" && out.type != "box")
    geom.refuse("fromto", fmt::format("a {} cannot have fromto; expected capsule, cylinder, ellipsoid or box",
                                      out.type));
  if (!out.X.p.isZero(0)) geom.refuse("has both pos and fromto; expected one of the two");
  const Vector3d from(ends[0], ends[1], ends[2]), to(ends[3], ends[4], ends[5]);
  const double half = (to - from).norm() / 2;
  if (half < 1e-14) geom.refuse("fromto", "its two points coincide");
  if (out.size.empty()) geom.refuse("has no size");
  out.size = round ? std::vector{out.size[0], half} : std::vector{out.size[0], out.size[0], half};
  out.X = {turn_from_z(from - to), (from + to) / 2};
  return out;
}

double size_at(const XmlElement& geom, const Sized& s, std::size_t i, std::size_t expected) {
  if (s.size.size() <= i)
    geom.refuse(fmt::format("a {} needs {} sizes, and {} are given", s.type, expected, s.size.size()));
  if (!(s.size[i] > 0))
    geom.refuse("size", fmt::format("size contains {:g}, expected positive numbers", s.size[i]));
  return s.size[i];
}

// (MuJoCo gives half lengths and half edges.)
std::optional<Form> form_of(const XmlElement& geom, const Sized& s) {
  const auto size = [&](std::size_t i, std::size_t expected) { return size_at(geom, s, i, expected); };
  if (s.type == "sphere") return Sphere{size(0, 1)};
  if (s.type == "capsule") return Capsule{size(0, 2), 2 * size(1, 2)};
  if (s.type == "cylinder") return Cylinder{size(0, 2), 2 * size(1, 2)};
  if (s.type == "ellipsoid") return Ellipsoid{{size(0, 3), size(1, 3), size(2, 3)}};
  if (s.type == "box") return Box{{2 * size(0, 3), 2 * size(1, 3), 2 * size(2, 3)}};
  return std::nullopt;
}

struct Facet {
  Vector3d a, b, c;
  Vector3d normal_area() const { return (b - a).cross(c - a) / 2; }
  Vector3d centre() const { return (a + b + c) / 3; }
};

std::vector<Facet> facets_of(const ClosedMesh& mesh) {
  std::vector<Facet> out;
  for (const auto& t : mesh.triangles)
    out.push_back({mesh.vertices[static_cast<std::size_t>(t[0])],
                   mesh.vertices[static_cast<std::size_t>(t[1])],
                   mesh.vertices[static_cast<std::size_t>(t[2])]});
  return out;
}

double volume_within(const ClosedMesh& mesh) {
  double volume = 0;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : mesh.vertices) middle += p / double(mesh.vertices.size());
  for (const Facet& f : facets_of(mesh)) volume += (f.centre() - middle).dot(f.normal_area()) / 3;
  return std::abs(volume);
}

// A mesh's maxhullvert.
int hull_vertices(const XmlElement& asset) {
  const int most = whole_number(asset, "maxhullvert", -1);
  if (most != -1 && most < 4)
    asset.refuse("maxhullvert", fmt::format("maxhullvert is {}, expected more than 3", most));
  return most;
}

// The edges of all triangles in their direction, as numbers of points: the corners of an STL file are not
// shared, so equal positions are one point. Triangles without area have none.
std::vector<std::pair<int, int>> edges_of(const ClosedMesh& mesh) {
  std::map<std::array<double, 3>, int> points;
  const auto number = [&](int v) {
    const Vector3d& p = mesh.vertices[static_cast<std::size_t>(v)];
    return points.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(points.size())).first->second;
  };
  std::vector<std::pair<int, int>> out;
  for (const auto& t : mesh.triangles) {
    const int a = number(t[0]), b = number(t[1]), c = number(t[2]);
    if (a != b && b != c && c != a) out.insert(out.end(), {{a, b}, {b, c}, {c, a}});
  }
  return out;
}

// Whether an edge belongs to an odd number of triangles.
bool has_gaps(const ClosedMesh& mesh) {
  std::set<std::pair<int, int>> odd;
  for (const auto& [a, b] : edges_of(mesh))
    if (const auto [at, is_new] = odd.insert(std::minmax(a, b)); !is_new) odd.erase(at);
  return !odd.empty();
}

// Whether the triangles are oriented consistently: no two traverse an edge in the same direction.
bool turned_alike(const ClosedMesh& mesh) {
  std::set<std::pair<int, int>> traversed;
  return std::ranges::all_of(edges_of(mesh), [&](const auto& edge) { return traversed.insert(edge).second; });
}

// The inertia at density 1 of the pyramids from the triangles to a centre (see legacy_mesh_inertial()).
// `signed_too`: inverted pyramids count as negative.
Inertial pyramids_inertial(const ClosedMesh& mesh, bool signed_too) {
  const auto volume_of = [&](const Facet& f, const Vector3d& tip) {
    const double volume = (f.centre() - tip).dot(f.normal_area()) / 3;
    return signed_too ? volume : std::abs(volume);
  };
  const std::vector<Facet> facets = facets_of(mesh);
  double area = 0;
  Vector3d middle = Vector3d::Zero();  // centroid of the surface
  for (const Facet& f : facets) {
    const double own = f.normal_area().norm();
    area += own;
    middle += own * f.centre();
  }
  Inertial out;
  if (!(area > 0)) return out;
  middle /= area;
  for (const Facet& f : facets) {
    const double volume = volume_of(f, middle);
    out.mass += volume;
    out.centre += volume * (0.75 * f.centre() + 0.25 * middle);
  }
  if (!(out.mass > 0)) return out;
  out.centre /= std::exchange(out.mass, 0);
  Matrix3d second = Matrix3d::Zero();  // integral of x x^T about the centre of mass
  for (const Facet& f : facets) {
    const Vector3d a = f.a - out.centre, b = f.b - out.centre, c = f.c - out.centre, sum = a + b + c;
    const double volume = volume_of(f, out.centre);
    out.mass += volume;
    second +=
        volume / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  out.tensor = second.trace() * Matrix3d::Identity() - second;
  return out;
}

}  // namespace

Inertial legacy_mesh_inertial(const ClosedMesh& mesh) { return pyramids_inertial(mesh, false); }

MjcfGeoms::MjcfGeoms(const XmlElement& root, const MjcfCompilers& compilers) : compilers_(compilers) {
  for (const XmlElement& section : root.children) {
    if (section.name != "asset") continue;
    section.read = true;
    for (const XmlElement& asset : section.children) {
      if (asset.name != "mesh") continue;
      std::string name = asset.text("name");
      if (name.empty()) name = std::filesystem::path(asset.require("file")).stem().string();
      if (!meshes_.emplace(name, Mesh{&asset}).second)
        asset.refuse("there are two meshes of this name; rename one");
    }
  }
}

std::string MjcfGeoms::overweight() const {
  if (overweight_.count == 0) return "";
  return fmt::format("{} meshes get more mass than their volume under MuJoCo's legacy rule, most of all {}",
                     overweight_.count, overweight_.worst);
}

std::string MjcfGeoms::gaps() const {
  if (gaps_.count == 0) return "";
  return fmt::format(
      "the gaps of {} meshes that are not closed (each weighs as the pyramids from its triangles to a "
      "centre, as in MuJoCo), first of {}",
      gaps_.count, gaps_.first);
}

MjcfGeom MjcfGeoms::read(const XmlElement& geom, bool weighs) {
  geom.read = true;
  for (const char* key : {"name", "class"}) geom.find(key);
  MjcfGeom out;
  out.group = whole_number(geom, "group", 0);
  const Sized s = sized(geom, compilers_);
  if (s.type == "plane") {
    out.plane = s.X;
    return out;
  }
  if (s.type == "hfield") {
    geom.read = false;  // for contact only: listed as not modelled
    return out;
  }
  std::optional<double> mass;
  if (geom.has("mass")) mass = geom.not_negative("mass", 0);
  const double density = geom.not_negative("density", 1000);
  weighs = weighs && mass.value_or(density) > 0;
  if (weighs && s.type == "sdf") geom.refuse("the mass of signed distance fields is not supported");
  if (s.type == "mesh" || s.type == "sdf") {
    if (s.type == "mesh") out.hull = hull_of(geom, s.X);
    if (!weighs) return out;
    Mesh& mesh = mesh_of(geom);
    out.inertial = weighed(weight(mesh), mass, density).expressed_in(s.X.R, s.X.p);
    return out;
  }
  if (geom.has("mesh")) {
    out.shape = fitted(geom, s.type, s.X);
  } else {
    const Quaternion q = quaternion(s.X.R);
    const Shape shape{*form_of(geom, s), s.X.p, Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
    out.shape = ShapeElement{.shape = shape, .density = {}, .mass = {}};
  }
  if (!weighs) return out;
  const Shape& shape = out.shape->shape;
  if (geom.boolean("shellinertia", false)) {
    const Inertial shell = weighed(shell_inertial(shape.form), mass, density);
    out.inertial = shell.expressed_in(shape.orientation.toRotationMatrix(), shape.position);
    return out;
  }
  const auto inertial = mass ? inertial_of_mass(shape, *mass) : inertial_of_density(shape, density);
  if (!inertial) geom.refuse(inertial.error().message());
  out.inertial = *inertial;
  return out;
}

Inertial MjcfGeoms::weighed(Inertial own, const std::optional<double>& mass, double density) {
  const double factor = mass ? *mass / own.mass : density;
  own.mass *= factor;
  own.tensor *= factor;
  return own;
}

MjcfGeoms::Mesh& MjcfGeoms::mesh_of(const XmlElement& geom) {
  const auto found = meshes_.find(geom.require("mesh"));
  if (found == meshes_.end())
    geom.refuse("mesh", fmt::format("<asset> has no mesh named '{}'", geom.require("mesh")));
  return found->second;
}

const ClosedMesh& MjcfGeoms::loaded(Mesh& mesh) const {
  if (!mesh.loaded) mesh.loaded = load(*mesh.asset);
  return *mesh.loaded;
}

// The hull of a mesh that may touch others, with no more vertices than it has corners.
std::optional<Shape> MjcfGeoms::hull_of(const XmlElement& geom, const Pose& X) {
  if (geom.number("contype", 1) == 0 && geom.number("conaffinity", 1) == 0 && !geom.has("name")) return {};
  Mesh& mesh = mesh_of(geom);
  if (!mesh.hull && !mesh.no_hull) {
    mesh.no_hull = true;
    try {
      const auto whole = convex_hull(loaded(mesh).vertices, hull_vertices(*mesh.asset));
      if (!whole) return {};
      std::map<int, int> numbers;
      ClosedMesh& kept = mesh.hull.emplace();
      for (auto triangle : whole->triangles) {
        for (int& v : triangle) {
          const auto [number, is_new] = numbers.emplace(v, int(kept.vertices.size()));
          if (is_new) kept.vertices.push_back(whole->vertices[static_cast<std::size_t>(v)]);
          v = number->second;
        }
        kept.triangles.push_back(triangle);
      }
    } catch (const XmlRefusal&) {  // no such file, or not a mesh: a model may be moved without its meshes
    }
  }
  if (!mesh.hull) return {};
  const Quaternion q = quaternion(X.R);
  return Shape{*mesh.hull, X.p, Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
}

ClosedMesh MjcfGeoms::load(const XmlElement& asset) const {
  asset.read = true;
  asset.find("class");
  for (const char* key : {"smoothnormal", "maxhullvert", "content_type", "normal", "texcoord", "material"})
    asset.find(key);  // for appearance and contacts only
  if (asset.has("builtin") && asset.text("builtin") != "none")
    asset.refuse("builtin", "built-in meshes are not supported; save the mesh as .stl or .obj");
  ClosedMesh mesh;
  if (asset.has("file")) {
    const MjcfCompiler& compiler = compilers_.of(asset);
    std::filesystem::path file = asset.require("file");
    if (compiler.strip_path) file = file.filename();
    auto read = read_triangles(compiler.folder / compiler.mesh_folder / file);
    if (!read) asset.refuse("file", read.error().message());
    mesh = std::move(*read);
  } else {
    constexpr std::size_t many = 100'000'000;
    const auto points = asset.numbers("vertex", 12, many), corners = asset.numbers("face", 3, many);
    if (points.empty()) asset.refuse("has neither file nor vertex");
    if (points.size() % 3 || corners.size() % 3)
      asset.refuse("vertex and face must contain groups of three numbers");
    for (std::size_t i = 0; i < points.size(); i += 3)
      mesh.vertices.emplace_back(points[i], points[i + 1], points[i + 2]);
    for (double corner : corners)
      if (corner < 0 || corner >= double(mesh.vertices.size()) || corner != std::floor(corner))
        asset.refuse("face", fmt::format("face refers to vertex {:g}; vertices run from 0 to {}", corner,
                                         mesh.vertices.size() - 1));
    for (std::size_t i = 0; i < corners.size(); i += 3)
      mesh.triangles.push_back({int(corners[i]), int(corners[i + 1]), int(corners[i + 2])});
  }
  if (mesh.triangles.empty()) {
    auto hull = convex_hull(mesh.vertices, hull_vertices(asset));
    if (!hull) asset.refuse(hull.error().what);
    mesh = std::move(*hull);
  }
  const Vector3d origin = asset.vector("refpos", Vector3d::Zero()),
                 scale = asset.vector("scale", Vector3d::Ones());
  Matrix3d turn = Matrix3d::Identity();
  if (const auto q = asset.numbers("refquat", 4, 4); !q.empty()) {
    const Quaternion given(q[0], q[1], q[2], q[3]);
    if (given.norm() < 1e-10) asset.refuse("refquat", "refquat is zero, expected a rotation");
    turn = rotation_matrix(given.normalized()).transpose();
  }
  for (Vector3d& p : mesh.vertices) p = scale.cwiseProduct(turn * (p - origin));
  if (scale.prod() < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// The mesh's inertia at density 1, by the rule that its `inertia` names.
const Inertial& MjcfGeoms::weight(Mesh& mesh) {
  if (mesh.weight) return *mesh.weight;
  const XmlElement& asset = *mesh.asset;
  const ClosedMesh& triangles = loaded(mesh);
  const std::string rule = asset.word("inertia", {"legacy", "exact", "convex", "shell"},
                                      compilers_.of(asset).exact_mesh_inertia ? "exact" : "legacy");
  const auto enclosed = [](const ClosedMesh& m) {
    return inertial_of_density({m, Vector3d::Zero(), Eigen::Quaterniond::Identity()}, 1);
  };
  Inertial own;
  if (rule == "legacy") {
    own = legacy_mesh_inertial(triangles);
    const double inside = volume_within(triangles), excess = own.mass / inside;
    if (excess > 1.01 && (++overweight_.count, excess > overweight_.excess)) {
      overweight_.excess = excess;
      overweight_.worst = fmt::format(
          "mesh '{}' with {:.4g} m^3 for {:.4g} m^3 (inertia=\"exact\" uses the enclosed volume): at {}",
          asset.text("name", std::filesystem::path(asset.text("file")).stem().string()), own.mass, inside,
          asset.where());
    }
  } else if (rule == "exact") {
    const auto exact = enclosed(triangles);
    if (exact) {
      own = *exact;
    } else {
      if (!turned_alike(triangles)) asset.refuse(exact.error().message());
      own = pyramids_inertial(triangles, true);
    }
  } else if (rule == "convex") {
    const auto hull = convex_hull(triangles.vertices, hull_vertices(asset));
    if (!hull) asset.refuse(hull.error().what);
    own = legacy_mesh_inertial(*hull);  // (exact for convex meshes)
  } else {
    own = shell_inertial(triangles);
  }
  if (!(own.mass > 0)) asset.refuse("encloses no volume");
  if ((rule == "legacy" || rule == "exact") && has_gaps(triangles) && ++gaps_.count == 1)
    gaps_.first = fmt::format("{}: at {}", asset.describe(), asset.where());
  mesh.weight = own;
  return *mesh.weight;
}

// A primitive fitted to a mesh (MuJoCo's mjCMesh::FitGeom): to the box of equal inertia, or to the box around
// the mesh along its principal axes.
ShapeElement MjcfGeoms::fitted(const XmlElement& geom, const std::string& type, const Pose& X) {
  Mesh& mesh = mesh_of(geom);
  const Inertial& own = weight(mesh);
  const PrincipalAxes principal = own.principal();  // ascending
  Matrix3d R;
  R << principal.axes.col(2), principal.axes.col(1), principal.axes.col(0);
  if (R.determinant() < 0) R.col(2) = -R.col(2);
  Pose X_box{R, own.centre};
  const Vector3d m = principal.moments.reverse();
  Vector3d half;
  for (int i = 0; i < 3; ++i) half[i] = 0.5 * std::sqrt(std::max(0.0, 6 * (m.sum() - 2 * m[i]) / own.mass));
  if (compilers_.of(geom).fit_box) {
    Eigen::AlignedBox3d around;
    for (const auto& t : mesh.loaded->triangles)
      for (const int v : t)
        around.extend(
            Vector3d(R.transpose() * (mesh.loaded->vertices[static_cast<std::size_t>(v)] - own.centre)));
    half = around.sizes() / 2;
    X_box.p += R * around.center();
  }
  const bool box = compilers_.of(geom).fit_box;
  half *= geom.number("fitscale", 1);
  const double across = box ? std::max(half[0], half[1]) : (half[0] + half[1]) / 2;
  std::vector<double> size{half[0], half[1], half[2]};
  if (type == "sphere") size = {box ? half.maxCoeff() : half.mean()};
  if (type == "cylinder") size = {across, half[2]};
  if (type == "capsule") size = {across, std::max(0.0, half[2] - (box ? across : across / 2))};
  const Pose placed = X * X_box;
  const Quaternion q = quaternion(placed.R);
  const Shape shape{*form_of(geom, {type, placed, size}), placed.p,
                    Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
  return ShapeElement{.shape = shape, .density = {}, .mass = {}};
}

}  // namespace borelli
