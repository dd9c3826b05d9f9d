// Reference points of a trunk, from which all else is found: hips, shoulders and the course of the spine.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/spheres.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"

namespace borelli {

/// Adult lengths, mm: half the distance between the hip centres; height of the shoulders above them.
inline constexpr double hips_half = 88, hip_to_shoulder = 515;

struct Trunk {
  std::array<std::optional<FoundSphere>, 2> hip, shoulder;  ///< femoral and humeral heads, by side
  /// Without hips and shoulders (lone_parts.hpp): the sections where the scan's upper end cuts the femora of
  /// legs alone, and the centre of a lone head's brain.
  std::array<std::optional<Eigen::Vector3d>, 2> femur;
  std::optional<Eigen::Vector3d> brain;
  /// Centre line of the vertebral column, one point per slice of the work grid, upwards; empty if not in
  /// view.
  std::vector<Eigen::Vector3d> spine;
  /// Levels (mm, patient z) of the lower and upper end of the lungs in view, without a twentieth of their
  /// volume at each end. Equal if there are less than 300 ml.
  std::array<double, 2> lungs{0, 0};
  /// Size relative to an adult of de Leva's male sample (stature 1.741 m), from what is in view.
  double scale = 1;

  AbsentParts absent{};  ///< parts that the user names as missing (--absent)
  /// By side: the limb is missing, and its hip or shoulder is the mirror image of the other (lone_heads.hpp).
  std::array<bool, 2> no_leg{}, no_arm{};

  /// True if nothing is in view from which parts can be found.
  bool empty() const { return !hip[0] && !shoulder[0] && !femur[0] && !brain; }
  /// The only side in view, if the scan's side cuts the body lengthwise. Hip and shoulder of the other side
  /// are then mirror images, out of view.
  std::optional<int> only_side;
  double middle_off = 0;       ///< standard deviation of the midsagittal plane in that case, mm
  bool column_in_view = true;  ///< false: the course is unknown, and only the levels of `spine` are valid
  /// The column's centre at a level (mm, patient z), clamped to its ends in x and y.
  Eigen::Vector3d spine_at(double z) const;
  bool spine_holds(double z) const;
  /// The midsagittal plane's x at a level, mm.
  double middle(double z) const;
};

/// Finds hips and shoulders as left-right pairs of spheres, about level, at the distance of an adult or a
/// large child, with flesh and spine between them. This distinguishes femoral heads from knees and humeral
/// heads from elbows. A pair that the surrounding anatomy does not confirm is rejected (heads_in_body.hpp).
/// The spine is the upward path from between the hips that contains most bone.
/// `not_hips`: spheres that proved not to be both hips; the next likely pair is taken.
Trunk find_trunk(const Anatomy& anatomy, const AbsentParts& absent = {},
                 const std::array<std::optional<FoundSphere>, 2>& not_hips = {});

/// Sets `spine` to the best column near x from `bottom` to `top` (mm, patient z). Each step up moves at most
/// one voxel sideways (dynamic programming). Iliac wings contain as much bone as the column, so the path is
/// held near x: at the bottom it is free within `far` mm, at height h within far + leaning * h. Farther out
/// the penalty grows with the square of the excess. Bone in the front half of the trunk beside the lungs does
/// not count: there the heart may hold contrast.
void find_spine(const Anatomy& anatomy, double x, double bottom, double top, double far, double leaning,
                Trunk& trunk);

}  // namespace borelli
