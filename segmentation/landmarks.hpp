// Named points of a body in the patient frame: joint centres, and the bony points that frames and cuts hang
// on.
//
// Joint centres carry the joint's name (see parts.hpp): neck (C7/T1 disc), spine_upper (disc at the xiphion's
// level), spine_lower (disc at the omphalion's level), shoulder_*, elbow_*, wrist_*, hip_*, knee_*, ankle_*.
// Other points: vertex, cervicale (tip of C7), suprasternale, xiphion, omphalion, mid_hip, asis_*,
// elbow_medial_*, elbow_lateral_* and knee_medial_*, knee_lateral_* (epicondyles: the hinge axes),
// lateral_malleolus_*, medial_malleolus_*, heel_*, toe_tip_*, metacarpale_3_*, dactylion_3_*;
// each * is left or right.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>

namespace borelli {

struct Landmark {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< mm, LPS
  double deviation = 0;                             ///< standard deviation of each coordinate, mm
  double radius = 0;   ///< of the fitted sphere or cylinder where the point is its centre, mm; else 0
  std::string source;  ///< how it was found: "exact", "bone: sphere on the femoral head", "proportion" ...
};

using Landmarks = std::map<std::string, Landmark, std::less<>>;

}  // namespace borelli
