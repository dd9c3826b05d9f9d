// Segments and joints of a limb: where along it upper arm, forearm and hand (thigh, shank and foot) follow
// each other most probably.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/proposal/limb_pieces.hpp"

namespace borelli {

/// A joint's place as the labeller proposes it, independent of the bones' form.
struct ProposedJoint {
  BodyRegion region = BodyRegion::arm;
  int side = -1;     ///< left_side or right_side; -1: not known
  std::string name;  ///< "elbow_left" ...; without a side where that is not known
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< mm, LPS
  double deviation = 0;  ///< standard deviation of each coordinate, mm; 0: the forest states none
};

struct LimbSegments {
  std::vector<std::uint8_t> part;  ///< #CoarseBody::places: label as in parts.hpp; trunk: that of the upper
                                   ///< trunk; 0: no piece, or a limb of unknown side
  std::vector<std::uint8_t> voxel_class;  ///< #places: index into voxel_classes
  std::vector<ProposedJoint> joints;
};

/// Distance along the limb from its root orders the voxels; two cuts of that order (which may fall together:
/// a segment that is not in view) give the three segments with the greatest sum of probabilities. A joint is
/// the middle of the limb's bone within 8 mm of a cut. Deviations are the forest's own (`joint` from its
/// training).
LimbSegments limb_segments(const CoarseBody& body, const ClassProbabilities& probabilities,
                           const BodyPieces& pieces, const Forest& forest);

}  // namespace borelli
