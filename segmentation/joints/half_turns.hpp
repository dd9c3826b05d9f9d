// Headers that lay the body the wrong way: its back where they say front, its feet where they say head.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// The body's own axes (left, back, up as columns, each along an axis of the header's or against it) where
/// they seem to be others than the header's; nothing where they agree or where too little is in view.
///
/// Front and back: between ribs and pelvis the column and the sacrum lie under the skin of the back, and
/// nothing bony lies near the skin of the belly; over some 300 mm of an adult's trunk bone is at least 40 mm
/// nearer to one skin than to the other (the pubis, over some 50 mm, the other way).
/// Up and down: above the lungs' tops lie head and neck (with arms overhead less than the chest weighs),
/// below them most of the body.
std::optional<Eigen::Matrix3d> half_turn(const Anatomy& anatomy, const Trunk& trunk);

/// In plain words what contradicts the header, by those axes.
std::string words_of_half_turn(const Eigen::Matrix3d& axes);

}  // namespace borelli
