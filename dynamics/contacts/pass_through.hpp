// What a model lets touch and its scene has no contact for: did it pass through each other?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/scene/shape.hpp"
#include "dynamics/scene/surface_contact.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

/// Something of a solid that others can touch.
struct Touchable {
  std::string name;                  ///< for people
  std::string solid;                 ///< of the scene, or "world"
  std::optional<Plane> plane;        ///< matter lies below it; its solid is the one above
  std::optional<ThickSegment> core;  ///< of a form; neither: nothing is known of its extent
};

/// A capsule within a form, along its longest axis: spheres and capsules themselves. None for a mesh or cone.
std::optional<ThickSegment> core_of(const Shape& shape);

struct TouchablePair {
  Touchable a, b;
};

/// The least distance of two segments, m, from the ends of both.
double segment_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& a_end, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& b_end);

/// Looks at the trajectory's rows: where the cores of a pair overlap by more than a hundredth of the smaller
/// radius (as deep as overlaps of contacts are trusted), its certificate trusts the motion no more, and says
/// which pair was the first, when, and how many others. What the cores leave out is not seen, nor what
/// happens between rows.
void judge_passing(const std::vector<TouchablePair>& pairs, Trajectory& trajectory);

}  // namespace borelli
