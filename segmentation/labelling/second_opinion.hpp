// Compares trunk, joints and parts with what the forest says of the same places.
#pragma once

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/proposal/proposal.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Whether no head of a femur or humerus lies in what is surely of another limb.
bool heads_agree(const Proposal& proposal, const Trunk& trunk);

/// Raises the deviations of joints that lie farther from where the proposal has them than its own errors
/// explain, to half of that distance. Passes over limbs that lack a segment (`absent`): the forest's cuts ask
/// for all three.
void doubt_joints_by_proposal(const Anatomy& anatomy, const AbsentParts& absent, Landmarks& landmarks);

/// Where parts and proposal contradict each other, lowers the parts' confidence and adds a warning:
/// - a part holds much that is surely of another limb;
/// - much that is surely of a limb is in no part of it.
void doubt_by_proposal(const Proposal& proposal, Segmentation& out);

}  // namespace borelli
