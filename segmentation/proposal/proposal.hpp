// The forest's view of a body: the limb of each voxel where it is sure, the limbs' roots and their joints.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/proposal/class_probabilities.hpp"
#include "segmentation/proposal/coarse_body.hpp"
#include "segmentation/proposal/limb_joints.hpp"
#include "segmentation/proposal/limb_pieces.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// Regions of a body with their sides; index 0: no sure region.
inline constexpr std::array<std::string_view, 7> body_limbs{"none",      "head",     "trunk",    "arm_left",
                                                            "arm_right", "leg_left", "leg_right"};
/// Index into body_limbs of a region; 0 for a limb of unknown side (-1).
constexpr std::size_t limb_of(BodyRegion region, int side) {
  if (!is_limb(region)) return region == BodyRegion::head ? 1 : 2;
  if (side < 0) return 0;
  return (region == BodyRegion::arm ? 3U : 5U) + (side == right_side ? 1U : 0U);
}
/// The same for a part of parts.hpp; 0 for label 0.
constexpr std::size_t limb_of_part(int label) {
  if (label <= 0) return 0;
  if (is_axial(label)) return limb_of(label == part_label("head") ? BodyRegion::head : BodyRegion::trunk, -1);
  const std::string_view name = parts[static_cast<std::size_t>(label)].name;
  return limb_of(label < part_label("thigh_left") ? BodyRegion::arm : BodyRegion::leg,
                 name.ends_with("_right") ? right_side : left_side);
}

struct Proposal {
  Grid grid;                           ///< step: labelling_step
  std::vector<std::uint8_t> limb;      ///< by offset: index into body_limbs where the region is sure; else 0
  std::vector<std::int16_t> piece_at;  ///< by offset: index into `pieces`; -1: in none
  std::vector<std::uint8_t> voxel_class;  ///< by offset: index into voxel_classes; valid within pieces
  std::vector<BodyPiece> pieces;
  std::vector<ProposedJoint> joints;

  /// The largest piece of a region and side (-1: head, trunk, or a limb of unknown side); null if there is none.
  const BodyPiece* piece(BodyRegion region, int side) const;
  /// Offset in `grid` of the place nearest to a voxel of another grid, which is parallel to it and starts at the
  /// same voxel.
  std::size_t place_of(const Grid& other, std::int64_t i, std::int64_t j, std::int64_t k) const;
};

/// Least probability of a sure region. In bodies that the forests had not seen in training, 99.7 % of such
/// voxels were right.
inline constexpr float sure_region = 0.9F;

/// Builds the proposal from class probabilities; `forest` states the joints' deviations.
Proposal proposal_of(const CoarseBody& body, const ClassProbabilities& probabilities, const Forest& forest);

/// Evaluates a forest (null: the built-in one). Errors: a forest with other features or classes; those of
/// ready_forest.
Result<Proposal> propose(const Anatomy& anatomy, const Forest* forest = nullptr);

/// Index into body_limbs of each voxel of a grid, as Proposal::limb. `grid` is parallel to the proposal's and
/// starts at the same voxel.
std::vector<std::uint8_t> sure_limbs(const Proposal& proposal, const Grid& grid, int threads);

}  // namespace borelli
