// Features of each voxel of the body, as integers: the forest's input.
//
// They do not depend on the body's place in the scan, and a mirrored body has the same features. Boxes count
// only what the scan shows, so that a scan may end anywhere. Features:
//   hu                             CT number of the voxel
//   depth, off_bone                see CoarseBody
//   <tissue>_<size>                share in a cube of `size` mm, in thousandths: body (of what is seen),
//                                  bone, fat, lung (of the body); hu_<size>: its mean CT number
//   <tissue>_<direction>_<reach>   body, bone, lung in a cube of 44 mm whose centre lies `reach` mm up, down,
//                                  front or back; the lesser and the greater of left and right.
//                                  -1: nothing is seen there (body), or no body is there (bone, lung)
//   run_*                          length of the body along a line from the voxel, mm, up to 400
//   piece_*, slice_*, off_piece_*  of the voxel's piece of its axial slice (slice_pieces.hpp)
//   way_*, section_*, beyond_*     of the body's branches (body_branches.hpp)
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "segmentation/proposal/body_branches.hpp"
#include "segmentation/proposal/box_sums.hpp"
#include "segmentation/proposal/coarse_body.hpp"
#include "segmentation/proposal/slice_pieces.hpp"

namespace borelli {

/// Names of the features, in the order of a row. A forest lists those that it was trained with.
const std::vector<std::string>& voxel_feature_names();

class VoxelFeatures {
 public:
  /// `body` must outlive this object.
  explicit VoxelFeatures(const CoarseBody& body);

  const CoarseBody& body() const { return body_; }
  const BodyBranches& branches() const { return branches_; }
  /// Fills `row` (#voxel_feature_names) for the body's voxel at an offset.
  void fill(std::size_t offset, std::span<std::int16_t> row) const;

 private:
  struct Runs {
    std::array<std::uint16_t, 4> length{};  ///< up, down, front, back
    std::uint16_t across_least = 0, across_most = 0;
  };
  void measure_runs();

  const CoarseBody& body_;
  BodyBranches branches_;
  SlicePieces pieces_;
  BoxSums seen_, hu_, flesh_, bone_, fat_, lung_;
  std::vector<Runs> runs_;            ///< by place of the body
  std::vector<std::uint32_t> place_;  ///< by offset: index into body_.places
};

}  // namespace borelli
