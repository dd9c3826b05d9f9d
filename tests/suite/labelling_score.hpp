// Agreement of the voxel labeller's proposal with a scan's exact parts.
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
  double right = 0;                   ///< share of voxels whose most probable class (of eight) is right
  double right_region = 0;            ///< the same of head, trunk, arm, leg
  double right_piece = 0;             ///< the same after forming pieces
  std::array<double, 6> limb_dice{};  ///< by limb_names; -1: neither has it
  std::array<double, voxel_class_count>
      class_dice{};         ///< after the pieces, both sides together; -1: neither has it
  Calibration calibration;  ///< of the regions of single voxels
  BodyPieces pieces;
  std::vector<double> piece_right;  ///< by piece: share of its voxels in its region and side
  struct Joint {
    std::string name;
    Eigen::Vector3d error;  ///< proposed minus true, mm
    double deviation = 0;
  };
  std::vector<Joint> joints;
  double seconds = 0, processor_seconds = 0;  ///< of labelling, without the anatomy
};

/// Labels the scan and scores the result. A joint's true position is the middle of the bone where its two
/// exact parts meet.
LabellingScore score_labelling(const LabelledScan& scan, const Forest& forest);

/// The mirrored body, with sides of parts exchanged.
LabelledScan mirrored(LabelledScan scan);

/// The scan without one limb's parts (a leg: thigh, shank, foot).
LabelledScan without_limb(LabelledScan scan, BodyRegion limb, int side);

}  // namespace borelli::suite
