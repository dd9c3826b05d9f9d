// Measures a skin's joints in a label map: thickness, axis, paths through the flesh.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "pipeline/export/skin.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Part indices + 1 (0: air) on an isotropic grid along the patient's axes, each voxel that of the nearest
/// voxel of `body`. `step`: m.
Volume<std::uint8_t> isotropic_parts(const Volume<std::uint8_t>& body, double step);

/// Measures each joint's half thickness on such a grid, and chooses its axis and the segment that it twists:
/// the longer one of the two that has a joint at its other end, no further child, and at least three half
/// thicknesses of length; without one, the zone around the joint. `joints`: in the order of parts.
void measure_joints(std::vector<SkinPart>& parts, const std::vector<SkinJoint>& joints,
                    const Volume<std::uint8_t>& coarse);

/// Length of the shortest path from the cut of a joint to each voxel of its two parts and of the parts that
/// joints connect to these, within them.
struct PathsFromCut {
  std::array<std::int64_t, 3> first{0, 0, 0}, size{0, 0, 0};  ///< box within the grid, voxels
  std::vector<float> lengths;                                 ///< of the box's voxels, m; infinite: no path

  float length(std::int64_t i, std::int64_t j, std::int64_t k) const {
    i -= first[0], j -= first[1], k -= first[2];
    if (i < 0 || j < 0 || k < 0 || i >= size[0] || j >= size[1] || k >= size[2])
      return std::numeric_limits<float>::infinity();
    return lengths[static_cast<std::size_t>((k * size[1] + j) * size[0] + i)];
  }
};

/// One for each part; empty for a part without a joint. `coarse`: without contacts (skin_contacts.hpp).
std::vector<PathsFromCut> paths_from_cuts(const std::vector<SkinPart>& parts,
                                          const Volume<std::uint8_t>& coarse, int threads);

}  // namespace borelli
