// The moving body as one file that any 3D viewer opens: glTF 2.0 binary (Khronos, ISO/IEC 12113:2022).
//
// Node tree: "world" (turns our Z up into glTF's Y up) holds one node per part, named as the part. A node's
// mesh is in the solid's own frame, its pose is animated (translation and rotation, LINEAR) by the
// trajectory.
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

/// X_WS of solids as they were scanned, by name: where the meshes' points, given in the world, belong.
using ScanPoses = std::map<std::string, Pose, std::less<>>;

struct GlbSettings {
  std::string title = "body";
  /// Of a trajectory recorded more densely, samples closer together than this are left out (the first and
  /// the last stay). A viewer interpolates between samples and is then off by at most a h^2 / 8: at 60 Hz
  /// 0.34 mm in free fall, 0.2 degrees at 100 rad/s^2.
  double samples_per_second = 60;
  /// Of meshes by name; those that are not here have their body part's, or grey.
  std::map<std::string, Colour, std::less<>> colours;
};

/// The file's bytes. A part without a solid (no pose at the scan, or absent from the trajectory) rests where
/// it was scanned; with an empty trajectory all do and there is no animation. Glb time 0 is the trajectory's
/// start. Errors: no mesh at all, a mesh without triangles or with an index or number out of range, two
/// meshes of one name.
Result<std::string> glb(const std::vector<Mesh>& meshes, const ScanPoses& X_WS_scan,
                        const Trajectory& trajectory, const GlbSettings& settings = {});

/// Indices of the trajectory's times that `glb` keeps: strictly increasing as floats, at most
/// `samples_per_second` apart.
std::vector<std::size_t> kept_samples(const std::vector<double>& times, double samples_per_second);

}  // namespace borelli
