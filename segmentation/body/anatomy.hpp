// What is known of a body before its parts are found: the scan on the work grid, masks of body and bone, and
// the maps and measures that later steps need.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/grid/morphology.hpp"
#include "segmentation/grid/work_grid.hpp"

namespace borelli {

struct Proposal;

struct Anatomy {
  const GreyVolume* source = nullptr;  ///< the scan itself, for close-ups; must outlive this object
  double size = 1;  ///< body size relative to normal; the scan is scaled by 1/size, and so are its lengths
  int threads = 0;  ///< number of threads; 0: all of the machine's
  WorkVolume scan;
  Mask body;
  Mask bone;
  Distances depth;        ///< depth below the skin, mm; 0 outside the body. The scan's edge is no skin.
  Distances off_bone;     ///< distance to the nearest bone voxel, mm, up to 60
  Distances within_bone;  ///< depth below a bone's surface, mm; 0 outside bone

  /// The forest's labelling (proposal/proposal.hpp); null: not computed.
  std::shared_ptr<const Proposal> proposal;
  /// By voxel: bit set of the seed kinds that may enter, where the proposal is sure of the limb (walls.hpp);
  /// empty: not computed.
  std::vector<std::uint8_t> wall;

  const Grid& grid() const { return scan.hu.grid; }
  double step() const { return grid().axes(0, 0); }
  /// True if the mask is set at a patient point (mm, LPS).
  bool holds(const Mask& mask, const Eigen::Vector3d& point) const;
  /// Extra deviation of a joint located by the gap between two bones, for voxels too large to show the gap,
  /// mm. It is 4 mm per millimetre of the largest spacing (of scan or work grid) above 5 mm times `scale`
  /// (see Trunk). Most such wrists are still found well, some are 20 to 35 mm off (`landmark_trials`,
  /// tests/suite).
  double gaps_unseen(double scale) const;
  /// True if a voxel (of scan or work grid) is as large as a wrist's gap, so that the bones may seem fused.
  bool gap_may_fuse(double scale) const;
  /// Excess of the voxel size over 3 mm of the patient's body, mm; the size is the larger of the scan's cube
  /// root of voxel volume and the work grid's step. Thin bone and its ends then show only where they hit a
  /// voxel's centre.
  double over_fine() const;
  /// True if the scan shows a patient point (mm, LPS).
  bool sees(const Eigen::Vector3d& point) const { return holds(scan.seen, point); }
  /// True within `reach` mm of voxels that the scan does not show.
  bool near_edge(const Eigen::Vector3d& point, double reach) const;
};

inline constexpr int left_side = 0, right_side = 1;
inline const char* side_suffix(int side) { return side == left_side ? "_left" : "_right"; }
/// +1 for the left (x grows to the left), -1 for the right.
inline double side_sign(int side) { return side == left_side ? 1 : -1; }

/// Computes the three distance maps from the current masks of body and bone.
void measure_depths(Anatomy& anatomy, int threads);

Anatomy anatomy_of(const GreyVolume& volume, double step, int threads);
/// The same on a grid from work_grid.
Anatomy anatomy_of(const GreyVolume& volume, const Grid& grid, int threads);

/// Peak memory in bytes per voxel of the work grid, for all volumes except the resampled scan.
inline constexpr std::size_t bytes_at_work = 36;

}  // namespace borelli
