// Segments and joints of a limb: the most probable sequence of upper arm, forearm and hand (thigh, shank and
// foot) along it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/proposal/limb_pieces.hpp"

namespace borelli {

/// A joint as the forest proposes it, independent of the bones' shape.
struct ProposedJoint {
  std::size_t piece = 0;  ///< index of the limb among the pieces
  BodyRegion region = BodyRegion::arm;
  int side = -1;                                    ///< left_side or right_side; -1: unknown
  std::string name;                                 ///< "elbow_left" ...; without a side if that is unknown
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< mm, LPS
  double deviation = 0;  ///< standard deviation of each coordinate, mm; 0: the forest states none
};

struct LimbSegments {
  /// #CoarseBody::places: label as in parts.hpp; the trunk gets that of the upper trunk. 0: in no piece, or
  /// in a limb of unknown side.
  std::vector<std::uint8_t> part;
  std::vector<std::uint8_t> voxel_class;  ///< #places: index into voxel_classes
  std::vector<ProposedJoint> joints;
};

/// Orders a limb's voxels by distance along it from its root. Two cuts of that order give the three segments
/// with the greatest sum of probabilities; the cuts may coincide if a segment is not in view. A joint is the
/// mean of the limb's bone within 8 mm of a cut. Deviations come from the forest (`joint` from its training).
LimbSegments limb_segments(const CoarseBody& body, const ClassProbabilities& probabilities,
                           const BodyPieces& pieces, const Forest& forest);

}  // namespace borelli
