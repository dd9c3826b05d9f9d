// Checks that make a segmentation doubtful: impossible sizes, unequal sides, uncertain joints.
#pragma once

#include <optional>

#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Below this confidence a part's bounds are uncertain.
inline constexpr double least_confidence = 0.5;
/// Joints with a larger deviation are doubtful, mm: 15 mm of a shank are 5 % of its mass.
inline constexpr double most_joint_deviation = 15;
/// Largest plausible volume ratio of left and right.
inline constexpr double most_side_ratio = 1.25;

/// The body's stature from distances between its joints, mm (de Leva 1996, Table 4, male): the median over
/// trunk, thighs, shanks, upper arms and forearms. Empty if fewer than two of these lengths are known.
std::optional<double> stature_of(const Landmarks& landmarks);

/// Lowers the confidence of parts with an impossible volume and says so in their notes. Limits: more than a
/// man of 250 kg has; for whole parts also less than half the volume at 12 kg/m^2, or more than twice that at
/// 60 kg/m^2, for this stature.
void doubt_impossible_volumes(Segmentation& out);

/// Adds a warning if all parts (except those given as absent) are whole and their total volume is impossible
/// for a person, or for a person of this stature.
void warn_of_body(Segmentation& out);

/// Calls doubt_impossible_volumes and warn_of_body. Also warns of each part of low confidence, and of each
/// pair of whole parts whose sides differ.
void warn_of_parts(Segmentation& out);

/// Adds warnings for joints with a large deviation, joints that the scan resolves too coarsely, and joints
/// whose best landmarks are not in view.
void warn_of_joints(const Grid& scan, Segmentation& out);

/// Adds the readers' warnings. A voxel size that no scan has makes the result doubtful.
void add_reader_warnings(const std::vector<std::string>& sentences, const Grid& scan, Segmentation& out);

}  // namespace borelli
