// What is known of a body before its parts are: the scan on the work grid, where the body is, where its bones
// are; and what the next steps need of it again and again.
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
  const GreyVolume* source = nullptr;  ///< the scan itself, for close-ups; outlives this
  double size = 1;  ///< of the body, in parts of the usual one's, which it is enlarged to; lengths are too
  int threads = 0;  ///< that steps may share their work among; 0: as many as the machine has
  WorkVolume scan;
  Mask body;
  Mask bone;
  Distances depth;        ///< below the skin, mm; 0 outside the body. The scan's edge is no skin.
  Distances off_bone;     ///< distance to the nearest bone voxel, mm, up to 60
  Distances within_bone;  ///< depth below a bone's surface, mm; 0 outside bone

  /// What the forest says of the body (proposal/proposal.hpp); null: not asked.
  std::shared_ptr<const Proposal> proposal;
  /// Of each voxel the kinds of seeds (bits) that may reach it, where the proposal is sure of its limb
  /// (walls.hpp); empty: not asked.
  std::vector<std::uint8_t> wall;

  const Grid& grid() const { return scan.hu.grid; }
  double step() const { return grid().axes(0, 0); }
  /// True where the mask is set at the voxel of a patient point.
  bool holds(const Mask& mask, const Eigen::Vector3d& point) const;
  /// What voxels too large to show the gap between two bones add to the deviation of a joint that is told by
  /// that gap, mm: 4 for each millimetre over 5 of the scan's largest spacing or of the work grid's step, in
  /// a body of usual size (`scale`: see Trunk). Most wrists come out well there, and some 20 to 35 mm off
  /// (measured by `landmark_trials`, tests/suite).
  double gaps_unseen(double scale) const;
  /// True where voxels or the work grid's are as large as a wrist's gap, which bones may then seem to fill.
  bool gap_may_fuse(double scale) const;
  /// By how much voxels (the edge of a cube as large) or the work grid's are over 3 mm of the patient: thin
  /// bone and its ends then show only where a voxel's middle hits them.
  double over_fine() const;
  /// True where the scan shows a patient point.
  bool sees(const Eigen::Vector3d& point) const { return holds(scan.seen, point); }
  /// True within `reach` mm of what the scan does not show.
  bool near_edge(const Eigen::Vector3d& point, double reach) const;
};

inline constexpr int left_side = 0, right_side = 1;
inline const char* side_suffix(int side) { return side == left_side ? "_left" : "_right"; }
/// +1 for the left (x grows to the left), -1 for the right.
inline double side_sign(int side) { return side == left_side ? 1 : -1; }

/// The three distance maps, from body and bone as they are.
void measure_depths(Anatomy& anatomy, int threads);

Anatomy look(const GreyVolume& volume, double step, int threads);
/// The same on a grid from work_grid.
Anatomy look(const GreyVolume& volume, const Grid& grid, int threads);

/// Bytes per voxel of the work grid, of all volumes in use at a time except the resampled scan.
inline constexpr std::size_t bytes_at_work = 36;

}  // namespace borelli
