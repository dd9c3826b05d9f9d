// What makes a segmentation doubtful: sizes that no body has, sides that differ, joints that may lie far off.
#pragma once

#include <optional>

#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Below this confidence a part's bounds are uncertain.
inline constexpr double least_confidence = 0.5;
/// A joint that may lie farther off is doubtful, mm: 15 mm of a shank are 5 % of its mass.
inline constexpr double most_joint_deviation = 15;
/// Left and right of a pair differ by no more, in volume, as a ratio.
inline constexpr double most_side_ratio = 1.25;

/// The body's stature by the distances of its joints, mm (de Leva 1996, Table 4, male): the median over
/// trunk, thighs, shanks, upper arms and forearms. Nothing where fewer than two of them are known.
std::optional<double> stature_of(const Landmarks& landmarks);

/// Lowers the confidence of parts that hold what no body has, and says so in their notes: more than a man of
/// 250 kg; of whole parts less than half or more than twice what a body of this stature has at 12 and 60
/// kg/m^2.
void doubt_impossible_volumes(Segmentation& out);

/// Adds a warning if all parts (but those told to be absent) are whole, and their volume is impossible for a
/// person or for one of this stature.
void warn_of_body(Segmentation& out);

/// Calls doubt_impossible_volumes and warn_of_body; adds a warning for each part of low confidence and for
/// each pair of whole parts whose sides differ.
void warn_of_parts(Segmentation& out);

/// Adds warnings for joints that may lie far off, or that the scan shows too coarsely, or without what tells
/// them best.
void warn_of_joints(const Grid& scan, Segmentation& out);

/// Adds what readers of the scan said: a voxel size that no scan has makes the result doubtful.
void add_reader_warnings(const std::vector<std::string>& sentences, const Grid& scan, Segmentation& out);

}  // namespace borelli
