// Hip joint centres by regression on the pelvis, for scans that do not show the femoral heads.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Inputs of the regressions, mm.
struct PelvisSize {
  double width = 0;             ///< between the anterior superior iliac spines (ASIS)
  std::optional<double> depth;  ///< from the midpoint of the ASIS to that of the posterior spines (PSIS)
  std::optional<double> leg;    ///< from the ASIS to the medial malleolus
};

enum class HipRegression {
  harrington,        ///< Harrington et al. 2007, J Biomech 40:595, from depth, width and leg
  harrington_width,  ///< same data, from the width alone: Sangeux 2015, Gait Posture 42:402
  hara,              ///< Hara et al. 2016, Sci Rep 6:37707, from the leg
  bell,              ///< Bell et al. 1989, Hum Mov Sci 8:3, from the width
};

/// The right hip's centre in the pelvis frame: origin midway between the ASIS, X forward, Y up, Z to the
/// right, mm. Empty if an input of the regression is unknown.
std::optional<Eigen::Vector3d> hip_centre(HipRegression regression, const PelvisSize& pelvis);

/// Adds hip_left, hip_right (not on a side in `no_leg`) and mid_hip if they are missing and both ASIS are
/// known. Uses the first regression whose inputs are known: Harrington with three lengths, Hara with the leg,
/// Harrington with the width. `source` begins with "regression" and names it.
///
/// The deviation combines the published error against imaged heads (12.3 +- 5.9 mm: Mantovani 2016, Gait
/// Posture 44:48), the spread of the applicable regressions, and 10 degrees of pelvic tilt if no PSIS gives
/// the tilt. Without PSIS the frame's Y follows the trunk (towards the neck; else patient z).
void place_unseen_hips(Landmarks& landmarks, const std::array<bool, 2>& no_leg = {});

/// The measured distance between the hips minus the one that Harrington's regression predicts from the width
/// between the ASIS, mm. Negative: the hips are too close. Zero if the difference is below three standard
/// deviations, or if a hip or ASIS was not measured or is doubtful.
double misfit_of_hips(const Landmarks& landmarks);

/// If the hips misfit, raises their deviations and that of mid_hip to half of the misfit. The hips' source
/// then ends with `unlike_body`.
void doubt_misfit_hips(Landmarks& landmarks);

}  // namespace borelli
