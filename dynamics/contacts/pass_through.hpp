// Detects shapes that passed through each other because the scene has no contact for them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/scene/shape.hpp"
#include "dynamics/scene/surface_contact.hpp"
#include "dynamics/system/trajectory.hpp"

namespace borelli {

/// A surface or shape of a solid that others can touch.
struct Touchable {
  std::string name;                  ///< for messages
  std::string solid;                 ///< name in the scene, or "world"
  std::optional<Plane> plane;        ///< matter of `solid` fills the half space below it
  std::optional<ThickSegment> core;  ///< inscribed capsule of a shape; neither plane nor core: extent unknown
};

/// A capsule inscribed in a shape along its longest axis; exact for spheres and capsules. None for a mesh or
/// cone.
std::optional<ThickSegment> core_of(const Shape& shape);

/// Surfaces and shapes of which some may touch but have no contact in the scene.
struct TouchablePairs {
  std::vector<Touchable> surfaces;
  std::vector<std::pair<int, int>> pairs;  ///< indices into `surfaces`
};

/// The least distance of two segments, m, given by their end points.
double segment_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& a_end, const Eigen::Vector3d& b,
                        const Eigen::Vector3d& b_end);

/// Checks every row of the trajectory for overlap of a pair's cores by more than a hundredth of the smaller
/// radius, the limit that also applies to contacts. If any overlap, the certificate becomes untrusted and
/// names the first pair, its time, and the number of other pairs. Overlap outside the cores or between rows
/// goes unnoticed.
void judge_passing(const TouchablePairs& touchable, Trajectory& trajectory);

}  // namespace borelli
