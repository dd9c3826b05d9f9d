#include "dynamics/mjcf_geom.hpp"

#include <fmt/core.h>

#include <utility>

#include "dynamics/triangle_file.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Sized {
  std::string type;
  Pose X;  // of the form in its body
  std::vector<double> size;
};

// Type, place and size, of which `fromto` may give a part: the ends of a form's axis z.
Sized sized(const XmlElement& geom, const MjcfCompiler& compiler) {
  Sized out;
  out.type = geom.word(
      "type", {"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"},
      "sphere");
  out.X = compiler.pose_of(geom);
  out.size = geom.numbers("size", 1, 3);
  const auto ends = geom.numbers("fromto", 6, 6);
  if (ends.empty()) return out;
  const bool round = out.type == "capsule" || out.type == "cylinder";
  if (!round && out.type != "ellipsoid" && out.type != "box")
    geom.refuse("fromto",
                fmt::format("a {} has no ends; expected capsule, cylinder, ellipsoid or box", out.type));
  if (!out.X.p.isZero(0)) geom.refuse("has both pos and fromto; expected one of the two");
  const Vector3d from(ends[0], ends[1], ends[2]), to(ends[3], ends[4], ends[5]);
  const double half = (to - from).norm() / 2;
  if (half < 1e-14) geom.refuse("fromto", "its two points are the same");
  if (out.size.empty()) geom.refuse("has no size");
  out.size = round ? std::vector{out.size[0], half} : std::vector{out.size[0], out.size[0], half};
  out.X = {turn_from_z(from - to), (from + to) / 2};
  return out;
}

double size_at(const XmlElement& geom, const Sized& s, std::size_t i, std::size_t expected) {
  if (s.size.size() <= i)
    geom.refuse(fmt::format("a {} takes {} sizes, {} are given", s.type, expected, s.size.size()));
  if (!(s.size[i] > 0))
    geom.refuse("size", fmt::format("size holds {:g}, expected positive numbers", s.size[i]));
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

}  // namespace

Inertial legacy_mesh_inertial(const ClosedMesh& mesh) {
  const std::vector<Facet> facets = facets_of(mesh);
  double area = 0;
  Vector3d middle = Vector3d::Zero();  // of the surface
  for (const Facet& f : facets) {
    const double own = f.normal_area().norm();
    area += own;
    middle += own * f.centre();
  }
  Inertial out;
  if (!(area > 0)) return out;
  middle /= area;
  for (const Facet& f : facets) {
    const double volume = std::abs((f.centre() - middle).dot(f.normal_area())) / 3;
    out.mass += volume;
    out.centre += volume * (0.75 * f.centre() + 0.25 * middle);
  }
  if (!(out.mass > 0)) return out;
  out.centre /= std::exchange(out.mass, 0);
  Matrix3d second = Matrix3d::Zero();  // integral of x x^T from the gravity centre
  for (const Facet& f : facets) {
    const Vector3d a = f.a - out.centre, b = f.b - out.centre, c = f.c - out.centre, sum = a + b + c;
    const double volume = std::abs((f.centre() - out.centre).dot(f.normal_area())) / 3;
    out.mass += volume;
    second +=
        volume / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  out.tensor = second.trace() * Matrix3d::Identity() - second;
  return out;
}

MjcfGeoms::MjcfGeoms(const XmlElement& root, const MjcfCompiler& compiler) : compiler_(compiler) {
  for (const XmlElement& section : root.children) {
    if (section.name != "asset") continue;
    section.read = true;
    for (const XmlElement& asset : section.children) {
      if (asset.name != "mesh") continue;
      std::string name = asset.text("name");
      if (name.empty()) name = std::filesystem::path(asset.require("file")).stem().string();
      if (!meshes_.emplace(name, Mesh{&asset}).second) asset.refuse("there are two meshes of this name");
    }
  }
}

MjcfGeom MjcfGeoms::read(const XmlElement& geom, bool weighs) {
  geom.read = true;
  for (const char* key : {"name", "class"}) geom.find(key);
  MjcfGeom out;
  out.group = static_cast<int>(geom.number("group", 0));
  const Sized s = sized(geom, compiler_);
  if (s.type == "plane") {
    out.plane = s.X;
    return out;
  }
  if (s.type == "hfield") {
    geom.read = false;  // a thing to touch only: listed
    return out;
  }
  if (s.type == "sdf") geom.refuse("signed distance fields are not supported");
  if (s.type != "mesh" && geom.has("mesh"))
    geom.refuse("mesh", fmt::format("fitting a {} to a mesh is not supported; give its size", s.type));
  if (weighs && geom.boolean("shellinertia", false))
    geom.refuse("shellinertia", "inertia of a shell is not supported; give the body an <inertial>");

  std::optional<double> mass;
  if (geom.has("mass")) mass = geom.not_negative("mass", 0);
  const double density = geom.not_negative("density", 1000);
  weighs = weighs && mass.value_or(density) > 0;
  if (s.type == "mesh") {
    if (weighs) out.inertial = mesh_inertial(geom, s.X, mass, density);
    return out;
  }
  const Quaternion q = quaternion(s.X.R);
  const Shape shape{*form_of(geom, s), s.X.p, Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
  out.shape = ShapeElement{.shape = shape, .density = {}, .mass = {}};
  if (!weighs) return out;
  const auto inertial = mass ? inertial_of_mass(shape, *mass) : inertial_of_density(shape, density);
  if (!inertial) geom.refuse(inertial.error().message());
  out.inertial = *inertial;
  return out;
}

const ClosedMesh& MjcfGeoms::mesh(const XmlElement& geom) {
  const auto found = meshes_.find(geom.require("mesh"));
  if (found == meshes_.end())
    geom.refuse("mesh", fmt::format("no mesh in <asset> is named '{}'", geom.require("mesh")));
  if (!found->second.loaded) found->second.loaded = load(*found->second.asset);
  return *found->second.loaded;
}

ClosedMesh MjcfGeoms::load(const XmlElement& asset) const {
  asset.read = true;
  asset.find("class");
  for (const char* key : {"smoothnormal", "maxhullvert"}) asset.find(key);  // of looks and contacts
  if (asset.has("builtin"))
    asset.refuse("builtin", "built-in meshes are not supported; save the mesh as .stl or .obj");
  ClosedMesh mesh;
  if (asset.has("file")) {
    std::filesystem::path file = asset.require("file");
    if (compiler_.strip_path) file = file.filename();
    auto loaded = read_triangles(compiler_.folder / compiler_.mesh_folder / file);
    if (!loaded) asset.refuse("file", loaded.error().message());
    mesh = std::move(*loaded);
  } else {
    constexpr std::size_t many = 100'000'000;
    const auto points = asset.numbers("vertex", 12, many), corners = asset.numbers("face", 3, many);
    if (points.empty() || corners.empty())
      asset.refuse("has no file, and not both vertex and face; hulls of points are not supported");
    if (points.size() % 3 || corners.size() % 3) asset.refuse("vertex and face must hold threes of numbers");
    for (std::size_t i = 0; i < points.size(); i += 3)
      mesh.vertices.emplace_back(points[i], points[i + 1], points[i + 2]);
    for (std::size_t i = 0; i < corners.size(); i += 3)
      mesh.triangles.push_back({int(corners[i]), int(corners[i + 1]), int(corners[i + 2])});
    for (double corner : corners)
      if (corner < 0 || corner >= double(mesh.vertices.size()) || corner != std::floor(corner))
        asset.refuse("face", fmt::format("face names vertex {:g}, but they go from 0 to {}", corner,
                                         mesh.vertices.size() - 1));
  }
  const Vector3d origin = asset.vector("refpos", Vector3d::Zero()),
                 scale = asset.vector("scale", Vector3d::Ones());
  Matrix3d turn = Matrix3d::Identity();
  if (const auto q = asset.numbers("refquat", 4, 4); !q.empty())
    turn = rotation_matrix(Quaternion(q[0], q[1], q[2], q[3]).normalized()).transpose();
  for (Vector3d& p : mesh.vertices) p = scale.cwiseProduct(turn * (p - origin));
  if (scale.prod() < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

Inertial MjcfGeoms::mesh_inertial(const XmlElement& geom, const Pose& X, std::optional<double> mass,
                                  double density) {
  const ClosedMesh& triangles = mesh(geom);
  const XmlElement& asset = *meshes_.at(geom.require("mesh")).asset;
  const std::string rule = asset.word("inertia", {"legacy", "exact", "convex", "shell"},
                                      compiler_.exact_mesh_inertia ? "exact" : "legacy");
  Inertial own;
  if (rule == "legacy") {
    own = legacy_mesh_inertial(triangles);
  } else if (rule == "exact") {
    const auto exact = inertial_of_density({triangles, Vector3d::Zero(), Eigen::Quaterniond::Identity()}, 1);
    if (!exact) asset.refuse(exact.error().message());
    own = *exact;
  } else {
    asset.refuse("inertia", fmt::format("the rule {} is not supported; expected legacy or exact", rule));
  }
  if (!(own.mass > 0)) asset.refuse("encloses no volume");
  const double factor = mass ? *mass / own.mass : density;
  own.mass *= factor;
  own.tensor *= factor;
  return own.expressed_in(X.R, X.p);
}

}  // namespace borelli
