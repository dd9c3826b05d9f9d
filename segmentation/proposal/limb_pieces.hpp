// Head, trunk and limbs as connected pieces, from the probabilities of single voxels.
//
// A piece consists of voxels whose most probable region is the same, and must contain enough voxels above a
// probability of 0.8 (hysteresis). A limb must contain a chain of bone; otherwise its voxels go to the
// surrounding pieces. Left and right come from where a limb joins the trunk: paths along its bones, from the
// bones next to the trunk, separate limbs that touch each other.
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
  int side = -1;          ///< left_side or right_side; -1: head, trunk, or a limb of unknown side
  double volume = 0;      ///< mm^3
  double bone_chain = 0;  ///< length of a limb's longest chain of bones across gaps up to 16 mm, mm
  /// Median of its border with the trunk (only the border within bone, if there is any); LPS, mm.
  std::optional<Eigen::Vector3d> root;
  bool root_in_bone = false;
  double root_area = 0;   ///< area of that border, mm^2
  bool cut = false;       ///< borders on voxels that the scan does not show
  double confidence = 0;  ///< mean probability of its region: the expected fraction of correct voxels
};

struct BodyPieces {
  std::vector<std::int16_t> piece;  ///< #CoarseBody::places: index into `list`; -1: connected to no piece
  std::vector<BodyPiece> list;
  std::vector<std::array<float, 4>> regions;  ///< #places: probability of each region, mean over neighbours
};

/// Without a trunk in view, a pair of limbs gets its sides from the pair's own middle; a single limb gets
/// none.
BodyPieces body_pieces(const CoarseBody& body, const ClassProbabilities& probabilities);

}  // namespace borelli
