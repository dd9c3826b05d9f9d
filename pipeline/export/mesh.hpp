// Makes one closed surface per part of a label map, or of the whole body: flying edges, smoothing,
// decimation.
//
// Flying edges (Schroeder, Maynard, Geveci (2015) IEEE LDAV, 33-40) run on one label's voxels, or on its
// share of blocks of voxels if these are finer than the tolerance requires. Windowed-sinc smoothing (Taubin,
// Zhang, Golub (1996) ECCV, 283-292) runs in index space, so that steps of thick slices are smoothed like
// those of thin ones. Then decimate.hpp. Finally the points move along their normals to restore the volume
// that smoothing and decimation removed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
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
  int label = 0;                                        ///< the part's number in its label map; 0: none
  std::optional<double> density = {};                   ///< mean density of the part, kg/m^3, if known
};

struct MeshOptions {
  /// Largest distance, m, from the surface before decimation; 0 keeps every triangle. Halved for a part whose
  /// volume would change, until it does not. (Smoothing, before that, moves the surface by a fraction of a
  /// voxel.)
  double tolerance = 0.001;
  int threads = 0;                       ///< 0: as many as the machine has; the meshes do not depend on it
  std::function<bool(double)> progress;  ///< share done, 0 to 1; false: stop
};

/// Surface of every label that has voxels, in the order of the labels. Each edge has two triangles. The
/// enclosed volume equals the voxels' within 0.5 % (parts of a few voxels: within half a voxel of thickness).
/// Errors: a label without a name.
Result<std::vector<Mesh>> part_meshes(const LabelMap& labels, const MeshOptions& options = {});

/// One surface, of this name, of all voxels that have a label; it encloses `volume`, m^3, as part_meshes'
/// surfaces do. `tolerance`: MeshOptions::tolerance. Decimation leaves no edge longer than `longest_edge`, m.
/// Errors: no voxel has a label.
Result<Mesh> body_mesh(const LabelMap& labels, double volume, const std::string& name, double tolerance,
                       double longest_edge);

/// Volume that a closed mesh encloses, m^3; negative where its triangles face inwards.
double enclosed_volume(const Mesh& mesh);

/// Whether each edge belongs to exactly two triangles with opposite directions along it.
bool is_closed(const Mesh& mesh);

}  // namespace borelli
