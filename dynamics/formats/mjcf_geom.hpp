// MJCF's geoms: shapes with a mass, and the meshes that they name.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

struct MjcfGeom {
  std::optional<Inertial> inertial;   ///< in its body's frame; none: massless
  std::optional<ShapeElement> shape;  ///< for display and contact; none for planes, height fields and meshes
  std::optional<Shape> hull;          ///< of a mesh that may touch others, if its file can be read
  std::optional<Pose> plane;          ///< pose of a plane in its body's frame; z points out of the material
  int group = 0;
};

/// Reads geoms, with the meshes of a model's <asset>.
class MjcfGeoms {
 public:
  MjcfGeoms(const XmlElement& root, const MjcfCompilers& compilers);

  /// Reads a geom with complete attributes (mjcf_defaults.hpp). Its mass is `mass`, else its volume (of a
  /// shell: its surface) times `density` (1000 kg/m^3 or kg/m^2 if not given). `weighs`: whether its inertia
  /// is needed; only then must mesh files be readable.
  MjcfGeom read(const XmlElement& geom, bool weighs);

  /// One line on meshes whose mass by the legacy rule exceeds that of the volume they enclose; empty: none.
  std::string overweight() const;
  /// One line on meshes that are not closed, and whose mass is therefore a guess; empty: none.
  std::string gaps() const;

 private:
  struct Mesh {
    const XmlElement* asset = nullptr;
    std::optional<ClosedMesh> loaded{};
    std::optional<Inertial> weight{};  // of density 1
    std::optional<ClosedMesh> hull{};
    bool no_hull = false;  // already searched; without `hull` there is none
  };

  /// An inertia at density 1 with this mass, else this density.
  static Inertial weighed(Inertial own, const std::optional<double>& mass, double density);
  Mesh& mesh_of(const XmlElement& geom);
  const ClosedMesh& loaded(Mesh& mesh) const;
  const Inertial& weight(Mesh& mesh);
  std::optional<Shape> hull_of(const XmlElement& geom, const Pose& X);
  ClosedMesh load(const XmlElement& asset) const;
  ShapeElement fitted(const XmlElement& geom, const std::string& type, const Pose& X);

  const MjcfCompilers& compilers_;
  struct {
    int count = 0;
    std::string first;
  } gaps_;
  struct {
    int count = 0;
    double excess = 0;  // the largest relative excess
    std::string worst;
  } overweight_;
  std::map<std::string, Mesh> meshes_;
};

/// Inertia of triangles by MuJoCo's `legacy` rule (its only one until `exact` came, the default up to 3.2).
/// The pyramids from a centre to the triangles all count as positive. The centre of mass comes from pyramids
/// with the centroid of the surface; volume and moments come from those with the centre of mass. The rule is
/// exact if these centres see the whole surface (convex meshes). Density 1 kg/m^3; frame of the triangles.
/// Mass zero for a flat mesh. (MuJoCo 2.2 gave a mesh without `mass` the volume of the box of equal inertia;
/// this is the volume itself, as in later versions.)
Inertial legacy_mesh_inertial(const ClosedMesh& mesh);

}  // namespace borelli
