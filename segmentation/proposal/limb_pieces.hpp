// Head, trunk and limbs as connected pieces, from the probabilities of single voxels.
//
// A piece starts where its region's probability exceeds 0.8 and grows over what is most probably of that
// region (hysteresis). A limb must hold a chain of bone, or it is none: what then is left goes to the pieces
// around it. Left and right come from where a limb hangs on the trunk: ways along its bones, from the bones
// next to the trunk, part limbs that touch each other.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "segmentation/proposal/class_probabilities.hpp"

namespace borelli {

enum class BodyRegion : std::uint8_t { head, trunk, arm, leg };
inline constexpr std::array<std::string_view, 4> body_region_names{"head", "trunk", "arm", "leg"};

/// Region of each of voxel_classes.
constexpr BodyRegion region_of(std::size_t voxel_class) {
  return voxel_class < 2   ? static_cast<BodyRegion>(voxel_class)
         : voxel_class < 5 ? BodyRegion::arm
                           : BodyRegion::leg;
}
constexpr bool is_limb(BodyRegion region) { return region >= BodyRegion::arm; }

struct BodyPiece {
  BodyRegion region = BodyRegion::trunk;
  int side = -1;      ///< left_side or right_side; -1: of a limb that it could not be told; of head and trunk
  double volume = 0;  ///< mm^3
  double bone_chain = 0;  ///< length of the longest chain of bones in a limb, gaps up to 16 mm, mm
  /// Median of its border with the trunk, patient frame, mm: of that in bone, where there is any.
  std::optional<Eigen::Vector3d> root;
  bool root_in_bone = false;
  double root_area = 0;   ///< of that border, mm^2
  bool cut = false;       ///< it reaches what the scan does not show
  double confidence = 0;  ///< mean probability of its region: the share of its voxels that should be right
};

struct BodyPieces {
  std::vector<std::int16_t> piece;  ///< #CoarseBody::places: index into `list`; -1: no piece is connected
  std::vector<BodyPiece> list;
  std::vector<std::array<float, 4>> regions;  ///< #places: probability of each region, mean over neighbours
};

/// Of a pair of limbs without a trunk in view, left and right are told about the pair's own middle; of a
/// single one they are not told.
BodyPieces body_pieces(const CoarseBody& body, const ClassProbabilities& probabilities);

}  // namespace borelli
