// Grids and volumes that several tests share.
#pragma once

#include <Eigen/Geometry>
#include <random>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A small rotated grid of three different spacings, optionally mirrored and sheared (`sheared`: mm along y
/// per slice).
inline Grid oblique_grid(bool mirrored, double sheared) {
  Grid grid;
  grid.size = {5, 7, 4};
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Eigen::Matrix3d shape = Eigen::Vector3d(0.7, 1.3, mirrored ? -5.0 : 5.0).asDiagonal();
  shape(1, 2) = sheared;
  grid.axes = turn * shape;
  grid.origin = {-123.4567, 45.678, 1234.5};
  return grid;
}

inline GreyVolume noise_volume(const Grid& grid, Quantity quantity) {
  GreyVolume volume;
  volume.grid = grid;
  volume.quantity = quantity;
  volume.voxels.resize(grid.count());
  std::mt19937 random(7);
  for (auto& v : volume.voxels) v = static_cast<std::int16_t>(static_cast<int>(random() % 2400) - 1024);
  return volume;
}

}  // namespace borelli
