// Writes the moving body as one file for any 3D viewer: glTF 2.0 binary (Khronos, ISO/IEC 12113:2022).
//
// Node tree: "world" (turns our Z up into glTF's Y up) holds one node per part, named after the part. A
// node's mesh is in the solid's own frame. The trajectory animates its pose (translation and rotation,
// LINEAR).
//
// With a skin the node tree is the skeleton: below "world" a joint per part, each below its parent's, and
// helpers beside them (skin.hpp). The mesh "skin" is a node of its own, already in glTF's axes, as the
// standard advises (3.7.3); inverse bind matrices lead from it to the joints.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/export/mesh.hpp"
#include "pipeline/files/palette.hpp"

namespace borelli {

struct Skin;  // skin.hpp

/// X_WS of the solids in the scan's pose, by name. The meshes' points are given in the world in this pose.
using ScanPoses = std::map<std::string, Pose, std::less<>>;

struct GlbSettings {
  std::string title = "body";
  /// Samples closer together than this are dropped (the first and the last stay). A viewer interpolates
  /// between samples, with an error of at most a h^2 / 8: at 60 Hz 0.34 mm in free fall, 0.2 degrees at 100
  /// rad/s^2.
  double samples_per_second = 60;
  /// Colours of meshes, by name; other meshes have the colour of their body part, or grey.
  std::map<std::string, Colour, std::less<>> colours;
};

/// Bytes of the file. A part without a solid (no scan pose, or absent from the trajectory) stays in its scan
/// pose. With an empty trajectory all parts do, and there is no animation. Glb time 0 is the trajectory's
/// start. Errors: no mesh, a mesh without triangles or with an index or number out of range, two meshes of
/// one name.
Result<std::string> glb(const std::vector<Mesh>& meshes, const ScanPoses& X_WS_scan,
                        const Trajectory& trajectory, const GlbSettings& settings = {});

/// The same with one skin in place of the parts' meshes (skin_of). A part without a solid moves with its
/// parent. Errors: as above; a skin without weights.
Result<std::string> glb(const Skin& skin, const Trajectory& trajectory, const GlbSettings& settings = {});

/// Indices of the trajectory's times that `glb` keeps: strictly increasing as floats, at most
/// `samples_per_second` apart.
std::vector<std::size_t> kept_samples(const std::vector<double>& times, double samples_per_second);

}  // namespace borelli
