// Where everything of the phantom stands before any solid is made: proportions, limb frames in the asked
// pose, landmarks, cut planes.
#pragma once

#include <array>
#include <vector>

#include "samples/phantom.hpp"

namespace borelli {

/// Lengths of a body of nominal stature, mm; see phantom_plan.cpp for their source.
struct Proportions {
  double stature, mass_kg;
  double head, thorax, sternum, abdomen, pelvis;  ///< VERT-CERV, CERV-XYPH, SUPR-XYPH, XYPH-OMPH, OMPH-MIDH
  double thigh, shank, foot;                      ///< HJC-KJC, KJC-AJC, HEEL-TTIP
  double upper_arm, forearm, palm, hand;          ///< SJC-EJC, EJC-WJC, WJC-MET3, WJC-DAC3
  double ankle;                                   ///< height of the ankle centre above the sole
  double asis_up;                                 ///< height of the ASIS above the hip centres
  double hip_half, asis_half, shoulder_half;      ///< from the midsagittal plane
  double bone;                                    ///< factor on the thickness of bones
  double arm_bone, leg_bone;                      ///< the limbs' own, of that
  /// Factors on the male's breadth and depth of flesh.
  double head_flesh, neck_flesh, chest_flesh, chest_depth, waist_flesh, pelvis_flesh, arm_flesh,
      forearm_flesh, hand_flesh, thigh_flesh, shank_flesh, foot_flesh, fat;
};

enum Side { left_side, right_side };
inline constexpr std::array<std::string_view, 2> side_name{"left", "right"};

/// A limb's frame: origin at its upper joint centre, x lateral, y posterior, z up along the limb (the foot's:
/// origin at the ankle, z square to the sole).
struct BodyPlan {
  Proportions size;
  /// Arms that cross the shoulders' planes below their reach, or a chest that does.
  bool crosses_shoulders = false;
  double neck, notch, xiphion, omphalion, asis, hip;  ///< levels above the sole, mm
  std::array<Frame, 2> upper_arm, forearm, hand, thigh, shank, foot;
  Landmarks landmarks;
  std::vector<Cut> cuts;

  /// What of space may belong to a part: the sides of the cuts that it has part in.
  std::vector<HalfSpace> region(int part) const;
};

/// Radii that landmarks and bones share, mm (times Proportions::bone).
inline constexpr double humeral_head = 24, femoral_head = 24, knee_condyle = 23, trochlea = 10,
                        talar_dome = 13;

/// Of the body that the options name, before it is scaled to its stature.
Proportions proportions(const PhantomOptions& options);
/// Sole to vertex where none is asked for, m.
double usual_stature(const PhantomOptions& options);
/// `build`: the asked mass in parts of the usual one at this stature; slight bodies have slighter bones.
Result<BodyPlan> plan_body(const PhantomOptions& options, double build);

}  // namespace borelli
