// Warped voxels brought onto a grid without holes: each as six tetrahedra on its corners.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"
#include "tests/suite/labelled_body.hpp"

namespace borelli::suite {

struct BodyRaster {
  Grid grid;
  std::vector<std::uint32_t> source;  ///< 1 + number of the body's voxel that holds the place, 0 outside
  double overlap = 0;                 ///< volume claimed by voxels more than 30 mm apart at rest, mm^3
};

/// `corner`: where the lattice's corners went, mm. Of voxels that claim one place bone wins, then the one
/// that is nearer its own bone. Voxels with `gone` set are left out (empty: none). The same on any number of
/// threads.
BodyRaster rasterise(const LabelledBody& body, const std::vector<Eigen::Vector3f>& corner,
                     const std::vector<std::uint8_t>& gone, const Grid& grid, int threads = 0);

}  // namespace borelli::suite
