// Hip joint centres where the femoral heads are not in view: by regression on the pelvis.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Lengths that the regressions take, mm.
struct PelvisSize {
  double width = 0;             ///< between the anterior superior iliac spines
  std::optional<double> depth;  ///< from their middle to that of the posterior ones
  std::optional<double> leg;    ///< from the anterior spine to the medial malleolus
};

enum class HipRegression {
  harrington,        ///< Harrington et al. 2007, J Biomech 40:595, on depth, width and leg
  harrington_width,  ///< the same bodies on the width alone: Sangeux 2015, Gait Posture 42:402
  hara,              ///< Hara et al. 2016, Sci Rep 6:37707, on the leg
  bell,              ///< Bell et al. 1989, Hum Mov Sci 8:3, on the width
};

/// The right hip's centre in the pelvis' frame: origin midway between the anterior spines, X forward, Y up,
/// Z to the right, mm. Nothing where a length that the regression takes is not known.
std::optional<Eigen::Vector3d> hip_centre(HipRegression regression, const PelvisSize& pelvis);

/// Adds hip_left, hip_right (but that of a side without a leg) and mid_hip where they are missing and both
/// anterior spines are there; `source`
/// begins with "regression" and names it. The one that takes most of what is known places the hip (Harrington
/// on three lengths, Hara on the leg, Harrington on the width). Its deviation: the error that was seen
/// against imaged heads (12.3 +- 5.9 mm over all: Mantovani 2016, Gait Posture 44:48), how far those that can
/// be had differ, and, where no posterior spine tells it, 10 degrees of pelvic tilt. Without posterior spines
/// the frame's Y is the trunk's way upwards (towards the neck; else patient z).
void place_unseen_hips(Landmarks& landmarks, const std::array<bool, 2>& no_leg = {});

}  // namespace borelli
