// MJCF's geoms: forms with a mass, and the meshes that they name.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

struct MjcfGeom {
  std::optional<Inertial> inertial;   ///< in its body's frame; none: it weighs nothing
  std::optional<ShapeElement> shape;  ///< to be seen and touched; none for planes, height fields and meshes
  std::optional<Pose> plane;          ///< of a plane, in its body's frame: z out of what it bounds
  int group = 0;
};

/// Reads geoms, with the meshes of a model's <asset>.
class MjcfGeoms {
 public:
  /// `notes`: receives remarks on how meshes weigh.
  MjcfGeoms(const XmlElement& root, const MjcfCompilers& compilers, std::vector<std::string>& notes);

  /// A geom, its attributes complete (mjcf_defaults.hpp). Its mass is `mass`, else its volume times `density`
  /// (1000 kg/m^3 if not given). `weighs`: whether its inertia is wanted, for which meshes are read from
  /// their files.
  MjcfGeom read(const XmlElement& geom, bool weighs);

  /// One line on meshes that weigh more by the legacy rule than they enclose; empty: none.
  std::string overweight() const;

 private:
  struct Mesh {
    const XmlElement* asset = nullptr;
    std::optional<ClosedMesh> loaded{};
    std::optional<Inertial> weight{};  // of density 1
  };

  Mesh& mesh_of(const XmlElement& geom);
  const ClosedMesh& loaded(Mesh& mesh) const;
  const Inertial& weight(Mesh& mesh);
  ClosedMesh load(const XmlElement& asset) const;
  ShapeElement fitted(const XmlElement& geom, const std::string& type, const Pose& X);

  const MjcfCompilers& compilers_;
  std::vector<std::string>& notes_;
  struct {
    int count = 0;
    double excess = 0;  // the largest share
    std::string worst;
  } overweight_;
  std::map<std::string, Mesh> meshes_;
};

/// Inertial elements of triangles by MuJoCo's `legacy` rule (its only one until `exact` came, the default up
/// to 3.2): the pyramids that the triangles span with a centre all count as positive; the gravity centre
/// comes from those with the surface's centre, volume and moments from those with the gravity centre. Exact
/// where these see the whole surface (convex meshes). Density 1 kg/m^3; the triangles' frame. Mass zero for a
/// flat mesh. (MuJoCo 2.2 gave a mesh without `mass` the volume of the box of equal inertia; this is the
/// volume itself, as later ones have it.)
Inertial legacy_mesh_inertial(const ClosedMesh& mesh);

/// The same by its `shell` rule: the surface weighs 1 kg/m^2.
Inertial shell_mesh_inertial(const ClosedMesh& mesh);

}  // namespace borelli
