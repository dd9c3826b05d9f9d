// Named points of a body in the patient frame: joint centres, and the bony points that define frames and
// cuts.
//
// Joint centres carry the joint's name (see parts.hpp): neck (C7/T1 disc), spine_upper (disc at the xiphion's
// level), spine_lower (disc at the omphalion's level), shoulder_*, elbow_*, wrist_*, hip_*, knee_*, ankle_*.
// Other points: vertex, cervicale (tip of C7), suprasternale, xiphion, omphalion, mid_hip, asis_*,
// elbow_medial_*, elbow_lateral_* and knee_medial_*, knee_lateral_* (epicondyles: the hinge axes),
// lateral_malleolus_*, medial_malleolus_*, heel_*, toe_tip_*, metacarpale_3_*, dactylion_3_*;
// each * is left or right.
// Discs, for the conventions dempster and bone: t12_l1, l4_l5, l5_s1.
// For ISB frames: t8 (its spinous process), psis_*, ulnar_styloid_*, radial_styloid_*, and the heads
// metatarsal_1_*, metatarsal_2_*, metatarsal_5_*.
// Where the scan does not show wrist or ankle: forearm_end_*, shank_end_* (where the scan cuts them).
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <string>
#include <string_view>

namespace borelli {

struct Landmark {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< mm, LPS
  double deviation = 0;                             ///< standard deviation of each coordinate, mm
  double radius = 0;   ///< of the fitted sphere or cylinder where the point is its centre, mm; else 0
  std::string source;  ///< how it was found: "exact", "bone: sphere on the femoral head", "proportion" ...
};

/// Suffixes of a landmark's source. They mark a landmark whose deviation was raised, because left and right,
/// or a limb's length and the body's size, differ more than in real bodies.
inline constexpr std::string_view unlike_other_side = ", unlike the other side's",
                                  unlike_body = ", unlike the body's size";

/// The names above; of sided names the stem, without _left or _right.
inline constexpr std::array<std::string_view, 13> landmark_names{
    "neck",    "spine_upper", "spine_lower", "vertex", "cervicale", "suprasternale", "xiphion", "omphalion",
    "mid_hip", "t12_l1",      "l4_l5",       "l5_s1",  "t8"};
inline constexpr std::array<std::string_view, 25> sided_landmark_names{"shoulder",
                                                                       "elbow",
                                                                       "wrist",
                                                                       "hip",
                                                                       "knee",
                                                                       "ankle",
                                                                       "asis",
                                                                       "elbow_medial",
                                                                       "elbow_lateral",
                                                                       "knee_medial",
                                                                       "knee_lateral",
                                                                       "lateral_malleolus",
                                                                       "medial_malleolus",
                                                                       "heel",
                                                                       "toe_tip",
                                                                       "metacarpale_3",
                                                                       "dactylion_3",
                                                                       "psis",
                                                                       "ulnar_styloid",
                                                                       "radial_styloid",
                                                                       "metatarsal_1",
                                                                       "metatarsal_2",
                                                                       "metatarsal_5",
                                                                       "forearm_end",
                                                                       "shank_end"};

using Landmarks = std::map<std::string, Landmark, std::less<>>;

}  // namespace borelli
