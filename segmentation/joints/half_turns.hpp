// Headers with a wrong patient position: front and back, or head and feet, exchanged.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// The body's own axes in the header's frame, if they differ from the header's; columns left, back, up, each
/// along or against a header axis. Empty if they agree or if too little is in view.
///
/// Front and back: between ribs and pelvis, spine and sacrum lie close to the skin of the back, and no bone
/// lies close to the skin of the belly. Over about 300 mm of an adult's trunk, bone is at least 40 mm nearer
/// to the back. Only the pubis, over about 50 mm, is that much nearer to the front. If less than 60 mm
/// of the trunk show the back, the pubis decides. It lies below and in front of the hips, and the midline has
/// no other bone at its level.
///
/// Up and down: head and neck above the lungs' tops, even with arms overhead, have less volume than the
/// chest. Most of the body lies below the lungs.
std::optional<Eigen::Matrix3d> half_turn(const Anatomy& anatomy, const Trunk& trunk);

/// Describes the contradiction between header and body for the user; `axes` from half_turn.
std::string words_of_half_turn(const Eigen::Matrix3d& axes);

}  // namespace borelli
