// Small copies of a scan and its labels for viewing: cubic voxels along the patient's axes, one byte each.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

struct Thumbnail {
  std::array<std::int64_t, 3> size{0, 0, 0};
  double spacing = 0;                                ///< mm, along each axis
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< centre of voxel (0, 0, 0), mm, LPS
  /// Grey value of byte b: low + b / 255 (high - low), clamped; in the quantity's unit.
  double low = 0, high = 0;
  std::vector<std::uint8_t> grey;    ///< i fastest; empty: no grey values
  std::vector<std::uint8_t> labels;  ///< i fastest; empty: no labels
};

/// The copy covers the labelled voxels with a margin of 30 mm, or the whole grid if nothing is labelled. It
/// is as fine as the source's finest axis, but has at most `most_voxels`. Grey values are means over the
/// copy's voxels (of up to 8 trilinear samples); labels are taken at their centres. At least one of `grey`
/// and `labels` must be given; each lies on its own grid.
Thumbnail thumbnail(const GreyVolume* grey, const LabelMap* labels, std::size_t most_voxels = 8'000'000,
                    int threads = 0);

}  // namespace borelli
