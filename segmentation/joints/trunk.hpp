// The fixed points of a trunk that all else is found from: hips, shoulders, and the course of the spine.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/spheres.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"

namespace borelli {

/// Of an adult, mm: half of what the hip centres are apart, and the height of the shoulders above them.
inline constexpr double hips_half = 88, hip_to_shoulder = 515;

struct Trunk {
  std::array<std::optional<FoundSphere>, 2> hip, shoulder;  ///< femoral and humeral heads, by side
  /// Where the scan's upper end cuts the femora of legs alone, and a lone head's brain's middle
  /// (lone_parts.hpp).
  std::array<std::optional<Eigen::Vector3d>, 2> femur;
  std::optional<Eigen::Vector3d> brain;
  /// Middle of the vertebral column, one point per slice of the work grid, upwards; empty where it is not
  /// seen.
  std::vector<Eigen::Vector3d> spine;
  /// Levels between which the lungs in view lie, but for a twentieth at each end (mm, patient z); equal where
  /// there is less than 300 ml.
  std::array<double, 2> lungs{0, 0};
  /// Size against an adult of de Leva's male sample (stature 1.741 m), from what is in view.
  double scale = 1;

  AbsentParts absent{};  ///< parts that the user names as missing (--absent)
  /// By side: the limb is missing, and its hip or shoulder is the mirror image of the other (lone_heads.hpp).
  std::array<bool, 2> no_leg{}, no_arm{};

  /// Nothing is in view that parts hang on.
  bool empty() const { return !hip[0] && !shoulder[0] && !femur[0] && !brain; }
  /// The only side in view of a body that the scan's side cuts lengthwise: hip and shoulder of the other are
  /// its mirror images, out of view.
  std::optional<int> only_side;
  double middle_off = 0;  ///< how far off the midsagittal plane may then be, mm (standard deviation)
  bool column_in_view =
      true;  ///< else the column's course is not seen, of which `spine` is then the level alone
  /// The column's middle at a level (mm, patient z), held to its ends.
  Eigen::Vector3d spine_at(double z) const;
  bool spine_holds(double z) const;
  /// The midsagittal plane's x at a level.
  double middle(double z) const;
};

/// Hips and shoulders are pairs of balls, left and right, about level, as far apart as an adult's (or a large
/// child's), with the body's own mass and column between them: this tells femoral heads from knees and
/// humeral heads from elbows; a pair that the body about it does not bear out is none (heads_in_body.hpp).
/// The column is the way upwards from between the hips that holds the most bone.
Trunk find_trunk(const Anatomy& anatomy, const AbsentParts& absent = {});

/// Sets `spine` to the best column about x from `bottom` to `top` (mm, patient z), each step up at most one
/// voxel sideways (dynamic programming). From `far` mm aside of x on a place counts for ever less: wings of a
/// pelvis hold as much bone as a column does.
void find_spine(const Anatomy& anatomy, double x, double bottom, double top, double far, Trunk& trunk);

}  // namespace borelli
