// How well the voxel labeller's proposal agrees with a scan's exact parts.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "segmentation/proposal/limb_joints.hpp"
#include "tests/suite/drawn_views.hpp"

namespace borelli::suite {

/// Head, trunk, both arms, both legs.
inline constexpr std::array<std::string_view, 6> limb_names{"head",      "trunk",    "arm_left",
                                                            "arm_right", "leg_left", "leg_right"};

struct Calibration {
  static constexpr std::size_t bins = 8;  ///< of the most probable region's probability, from 0.2 on by 0.1
  std::array<double, bins> voxels{}, right{};
};

struct LabellingScore {
  double voxels = 0;
  double right = 0;                   ///< share of voxels whose most probable class of eight is right
  double right_region = 0;            ///< the same of head, trunk, arm, leg
  double right_piece = 0;             ///< the same after the pieces were made
  std::array<double, 6> limb_dice{};  ///< by limb_names; -1: neither has it
  std::array<double, voxel_class_count>
      class_dice{};         ///< after the pieces, both sides together; -1: neither has it
  Calibration calibration;  ///< of the regions of single voxels
  BodyPieces pieces;
  std::vector<double> piece_right;  ///< by piece: share of its voxels that are of its region and side
  struct Joint {
    std::string name;
    Eigen::Vector3d error;  ///< proposed less true, mm
    double deviation = 0;
  };
  std::vector<Joint> joints;
  double seconds = 0, processor_seconds = 0;  ///< of labelling, without the anatomy
};

/// Labels the scan. The truth of a joint is the middle of the bone where the exact parts on both its sides
/// meet.
LabellingScore score_labelling(const LabelledScan& scan, const Forest& forest);

/// The body seen in a mirror, its parts' sides exchanged.
LabelledScan mirrored(LabelledScan scan);

/// The scan with the parts whose names begin so, and end in the side, gone ("leg": thigh, shank, foot).
LabelledScan without_limb(LabelledScan scan, BodyRegion limb, int side);

}  // namespace borelli::suite
