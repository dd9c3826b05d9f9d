// Checks of joints by limb lengths: left and right are nearly alike.
#pragma once

#include <string>

#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Places an ankle that is missing because the scan's side cuts the shank (a narrow field of view hides where
/// the tibia broadens): at the other shank's length along the path. Keeps an ankle that was found.
void place_cut_ankles(const Trunk& trunk, const Limbs& limbs, Landmarks& marks);

/// True if a comparison of lengths marked the joint as doubtful.
bool is_doubted(const Landmark& mark);

/// Raises the deviation of `joint` + `side` ("elbow", "_left") to at least `least` mm, and of its epicondyles,
/// which are as far off.
void raise_deviation(const std::string& joint, const std::string& side, double least, Landmarks& marks);

/// Compares each limb's lengths from joint to joint, left with right. Also compares them with the body's size
/// if hips and shoulders both give it, and forearms with upper arms otherwise or if the arm is cut.
///
/// Left and right disagree if they differ by more than 3 % of the length plus the joints' deviations. The far
/// joint with the clearly larger deviation is then doubtful; else the one whose length is unlikely for the
/// body; else both. Both are doubtful in arms that touch, since the length that one gains the other loses,
/// and on `large_voxels`, where the end of another bone passes for a cylinder.
///
/// The deviations of a doubtful joint and its epicondyles grow to the difference. Its source ends with
/// `unlike_other_side`, or with `unlike_body` if only the body's size contradicts it.
void doubt_unlike_lengths(const Trunk& trunk, const Limbs& limbs, Landmarks& marks,
                          bool large_voxels = false);

}  // namespace borelli
