// Draws warped voxels onto a grid without holes, each as six tetrahedra.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"
#include "tests/suite/labelled_body.hpp"

namespace borelli::suite {

struct BodyRaster {
  Grid grid;
  std::vector<std::uint32_t> source;  ///< 1 + number of the body's voxel at this point, 0 outside
  double overlap = 0;                 ///< volume claimed by voxels more than 30 mm apart at rest, mm^3
};

/// `corner`: positions of the moved lattice corners, mm. Of voxels that claim one point, bone wins, then the
/// voxel nearer to its bone. Voxels with `gone` set are omitted (empty: none). The result does not depend on
/// the number of threads.
BodyRaster rasterise(const LabelledBody& body, const std::vector<Eigen::Vector3f>& corner,
                     const std::vector<std::uint8_t>& gone, const Grid& grid, int threads = 0);

}  // namespace borelli::suite
