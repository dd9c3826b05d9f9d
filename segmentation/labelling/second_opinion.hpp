// Compares trunk, joints and parts with the forest's proposal.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/proposal/proposal.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// False if a femoral or humeral head lies where the proposal is sure of another limb.
bool heads_agree(const Proposal& proposal, const Trunk& trunk);

/// Raises the deviation of joints that disagree with the proposal. If the distance exceeds what the
/// proposal's own errors explain, the deviation becomes half of the distance. Skips limbs that lack a segment
/// (`absent`): the forest's joints need all three segments.
void doubt_joints_by_proposal(const Anatomy& anatomy, const AbsentParts& absent, Landmarks& landmarks);

/// Share of the labelled volume where the proposal is sure of another limb than the label's, among that where it
/// is sure of any; 0 without labels.
double contradicted_share(const Proposal& proposal, const LabelMap& labels);

/// Lowers confidence and adds a warning where parts and proposal contradict each other:
/// - a large volume of a part surely belongs to another limb;
/// - a large volume that surely belongs to a limb is in none of its parts.
void doubt_by_proposal(const Proposal& proposal, Segmentation& out);

}  // namespace borelli
