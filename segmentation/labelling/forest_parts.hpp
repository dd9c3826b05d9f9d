// Parts of a scan that shows no hips, no shoulders, no pair of whole legs and no head: an abdomen, a chest
// without shoulders, knees, one leg. The forest's proposal alone names them.
#pragma once

#include <array>
#include <cstdint>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct ForestParts {
  Volume<std::uint8_t> bones;  ///< label (see parts.hpp) of each bone voxel of the work grid; 0: none
  Landmarks landmarks;         ///< the proposal's joints; the levels that bound the trunk's parts
  /// By label: expected share of its voxels that are right; 0: not in view.
  std::array<double, parts.size()> confidence{};
  /// By label: whether it comes from an arm before or behind the trunk, which may belong to either shoulder.
  std::array<bool, parts.size()> side_unsure{};
  bool empty() const { return landmarks.empty() && confidence == std::array<double, parts.size()>{}; }
};

/// Takes the proposal's pieces of which at least three quarters are expected to be right. A leg without a trunk
/// in view must show tibia and fibula beside each other: the fibula is the thinner and the lateral one, which
/// also gives the leg's side, or be one of a pair, or `trunk.absent` must name the other leg. An arm without a trunk
/// in view is not taken: its side is unknown, and the forest takes most for legs.
/// The trunk is cut at the xiphion's level, from the lower end of the lungs, and at the omphalion's level, from
/// the iliac crests, where the scan shows these; see forest_parts.cpp for the distances.
/// `trunk`: its lungs and missing parts. The anatomy must have a proposal.
ForestParts parts_by_forest(const Anatomy& anatomy, const Trunk& trunk);

/// Whether the iliac crests lie less than 90 mm (of an adult) above the hips: then these are no femoral heads. The
/// anatomy must have a proposal, whose trunk shows the crests.
bool hips_near_crests(const Anatomy& anatomy, const Trunk& trunk);

/// Limbs whose shoulders (hips) are out of view: where bones of such a limb have no label, it gets those of
/// parts_by_forest, and the limb its joints.
void add_rootless_limbs(const Anatomy& anatomy, const Trunk& trunk, Volume<std::uint8_t>& bones,
                        Landmarks& landmarks);

/// Lowers the confidence of the parts to the forest's own, and says where they come from. Doubts trunk parts that the
/// scan cuts without a border to the next part.
void doubt_forest_parts(const ForestParts& forest, Segmentation& out);

}  // namespace borelli
