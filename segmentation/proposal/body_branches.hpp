// The body's branches: limbs as a tree of sections, whatever the pose.
//
// Shortest ways in the flesh from the body's middle give each voxel its distance. Voxels of one band of
// distance that are connected form a section. The sections form a Reeb graph (Reeb 1946, C. R. Acad. Sci.
// 222:847), which is taken as a tree: each section hangs on the one that it shares most faces with in the
// band before.
#pragma once

#include <cstdint>
#include <vector>

#include "segmentation/proposal/coarse_body.hpp"

namespace borelli {

struct BodySection {
  std::int32_t parent = -1;      ///< index of the section before; -1: the first one, or a piece of its own
  std::int32_t main_child = -1;  ///< the one with most volume beyond
  std::int32_t band = 0;         ///< number of its band of distance
  std::int32_t voxels = 0, bone = 0;
  std::int32_t voxels_beyond = 0, bone_beyond = 0;  ///< of itself and all that hang on it
  std::int32_t last_band = 0;                       ///< the farthest band of these
  bool cut = false;                                 ///< one of these borders on what the scan does not show
};

struct BodyBranches {
  std::vector<std::int32_t> section;       ///< by offset: index into `sections`; -1 outside the body
  std::vector<BodySection> sections;       ///< ordered by band
  std::vector<std::uint16_t> from_middle;  ///< by offset, mm
  /// Distances to ends (farthest points of the flesh), mm: to the nearest, the next, and the farthest.
  std::vector<std::uint16_t> nearest_end, next_end, farthest_end;
};

/// Width of a band, mm.
inline constexpr double band_width = 12;
/// A distance that no way has: pieces apart from the others.
inline constexpr std::uint16_t no_distance = 4000;

BodyBranches body_branches(const CoarseBody& body);

}  // namespace borelli
