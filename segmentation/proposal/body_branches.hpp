// The body's branches: limbs as a tree of sections, in any pose.
//
// The distance of each voxel is the length of the shortest path through flesh from the body's centre.
// Connected voxels within one band of distance form a section. The sections form a Reeb graph (Reeb 1946, C.
// R. Acad. Sci. 222:847), reduced to a tree: the parent of a section is the one in the band before that
// shares most faces with it.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/proposal/coarse_body.hpp"

namespace borelli {

struct BodySection {
  std::int32_t parent = -1;      ///< index of the section before; -1: the first one, or a piece of its own
  std::int32_t main_child = -1;  ///< the child with the largest volume beyond
  std::int32_t band = 0;         ///< index of its band of distance
  std::int32_t voxels = 0, bone = 0;
  std::int32_t voxels_beyond = 0, bone_beyond = 0;  ///< of itself and all its descendants
  std::int32_t last_band = 0;                       ///< their farthest band
  bool cut = false;  ///< one of them borders on voxels that the scan does not show
};

struct BodyBranches {
  std::vector<std::int32_t> section;       ///< by offset: index into `sections`; -1 outside the body
  std::vector<BodySection> sections;       ///< ordered by band
  std::vector<std::uint16_t> from_middle;  ///< distance from the centre by offset, mm
  /// Distances to the ends (farthest points of the flesh), by offset, mm: the nearest, the second nearest,
  /// the farthest.
  std::vector<std::uint16_t> nearest_end, next_end, farthest_end;
};

/// Width of a band, mm.
inline constexpr double band_width = 12;
/// Marks voxels that no path reaches: pieces apart from the others.
inline constexpr std::uint16_t no_distance = 4000;

BodyBranches body_branches(const CoarseBody& body);

}  // namespace borelli
