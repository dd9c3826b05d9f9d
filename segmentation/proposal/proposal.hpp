// What the forest says of a body: which limb each place is surely of, and where limbs begin and bend.
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

/// Regions of a body with their sides; index 0 stands for no region that is sure.
inline constexpr std::array<std::string_view, 7> body_limbs{"none",      "head",     "trunk",    "arm_left",
                                                            "arm_right", "leg_left", "leg_right"};
/// Index into body_limbs of a region; 0 of a limb of unknown side (-1).
constexpr std::size_t limb_of(BodyRegion region, int side) {
  if (!is_limb(region)) return region == BodyRegion::head ? 1 : 2;
  if (side < 0) return 0;
  return (region == BodyRegion::arm ? 3U : 5U) + (side == right_side ? 1U : 0U);
}
/// The same of a part of parts.hpp; 0 of label 0.
constexpr std::size_t limb_of_part(int label) {
  if (label <= 0) return 0;
  if (is_axial(label)) return limb_of(label == part_label("head") ? BodyRegion::head : BodyRegion::trunk, -1);
  const std::string_view name = parts[static_cast<std::size_t>(label)].name;
  return limb_of(label < part_label("thigh_left") ? BodyRegion::arm : BodyRegion::leg,
                 name.ends_with("_right") ? right_side : left_side);
}

struct Proposal {
  Grid grid;                       ///< of labelling_step
  std::vector<std::uint8_t> limb;  ///< by offset: index into body_limbs where that is sure; else 0
  std::vector<BodyPiece> pieces;
  std::vector<ProposedJoint> joints;

  /// The piece of an arm or leg of one side; null where none is in view or its side is not known. Of several
  /// the largest.
  const BodyPiece* piece(BodyRegion region, int side) const;
};

/// Sure is a place whose region is most probable by at least this. Of bodies that forests trained alike had
/// not seen, 99.7 % of such places were of that region.
inline constexpr float sure_region = 0.9F;

/// From each place's probabilities; `forest` states the joints' deviations.
Proposal proposal_of(const CoarseBody& body, const ClassProbabilities& probabilities, const Forest& forest);

/// Asks a forest (null: the one that the program holds). Errors: a forest with other features or classes;
/// those of ready_forest.
Result<Proposal> propose(const Anatomy& anatomy, const Forest* forest = nullptr);

/// Index into body_limbs of each voxel of a grid, as Proposal::limb. `grid` is parallel to the proposal's and
/// starts at the same voxel.
std::vector<std::uint8_t> sure_limbs(const Proposal& proposal, const Grid& grid, int threads);

}  // namespace borelli
