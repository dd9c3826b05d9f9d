// One closed surface per part of a label map: flying edges, smoothed, decimated.
//
// Flying edges (Schroeder, Maynard, Geveci (2015) IEEE LDAV, 33-40) on one label's voxels, or its share of
// blocks of them where they are finer than the tolerance asks for; windowed-sinc smoothing (Taubin, Zhang,
// Golub (1996) ECCV, 283-292) in index space, so that the steps of thick slices are smoothed as those of thin
// ones; then decimate.hpp. What smoothing and decimation take off the volume is given back by moving the
// points along their normals.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A closed triangle mesh in the world frame W (patient axes, metres). Triangles are counter-clockwise seen
/// from outside.
struct Mesh {
  std::string name;                                     ///< the part's, e.g. "thigh_left"
  std::vector<Eigen::Vector3f> points;                  ///< p_WP, m
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into points
};

struct MeshOptions {
  /// How far the surface may lie from the one before decimation, m; 0 keeps every triangle. Of a part that
  /// would lose or gain volume it is halved until it does not. (Before that, smoothing moves the surface by a
  /// fraction of a voxel.)
  double tolerance = 0.001;
  int threads = 0;                       ///< 0: as many as the machine has; the meshes do not depend on it
  std::function<bool(double)> progress;  ///< share done, 0 to 1; false: stop
};

/// The surface of every label that has voxels, in the order of the labels. Each edge has two triangles; the
/// enclosed volume is the voxels' within 0.5 % (parts of a few voxels: as near as half a voxel of thickness
/// allows). Errors: a label without a name.
Result<std::vector<Mesh>> part_meshes(const LabelMap& labels, const MeshOptions& options = {});

/// Volume that a closed mesh encloses, m^3; negative where its triangles face inwards.
double enclosed_volume(const Mesh& mesh);

/// Whether each edge belongs to exactly two triangles, which pass it in opposite senses.
bool is_closed(const Mesh& mesh);

}  // namespace borelli
