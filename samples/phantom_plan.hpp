// Layout of the phantom before any solid is made: proportions, limb frames in the requested pose, landmarks,
// cut planes.
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
  double arm_bone, leg_bone;                      ///< factors of the limbs' bones, relative to `bone`
  /// Factors on breadth and depth of the male's flesh.
  double head_flesh, neck_flesh, chest_flesh, chest_depth, waist_flesh, pelvis_flesh, arm_flesh,
      forearm_flesh, hand_flesh, thigh_flesh, shank_flesh, foot_flesh, fat;
};

enum Side { left_side, right_side };
inline constexpr std::array<std::string_view, 2> side_name{"left", "right"};

/// Layout of the body. A limb's frame has its origin at its upper joint centre, x lateral, y posterior, z up
/// along the limb (foot: origin at the ankle, z normal to the sole).
struct BodyPlan {
  Proportions size;
  /// Arms or the chest cross the shoulders' planes below the shoulders.
  bool crosses_shoulders = false;
  double neck, notch, xiphion, omphalion, asis, hip;  ///< levels above the sole, mm
  std::array<Frame, 2> upper_arm, forearm, hand, thigh, shank, foot;
  Landmarks landmarks;
  std::vector<Cut> cuts;

  /// The half-spaces that bound a part: the sides of the cuts that it takes part in.
  std::vector<HalfSpace> region(int part) const;
};

/// Radii that landmarks and bones share, mm (times Proportions::bone).
inline constexpr double humeral_head = 24, femoral_head = 24, knee_condyle = 23, trochlea = 10,
                        talar_dome = 13;

/// Proportions of the body that the options name, before scaling to its stature.
Proportions proportions(const PhantomOptions& options);
/// Default stature, sole to vertex, m.
double usual_stature(const PhantomOptions& options);
/// `build`: requested mass over the default mass at this stature; slender bodies have thinner bones.
Result<BodyPlan> plan_body(const PhantomOptions& options, double build);

}  // namespace borelli
