// Where the markers of a motion laboratory sit on a scanned body, by their names.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/joint_mapping.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct BodyMarker {
  std::string name;     ///< as recorded
  std::string segment;  ///< the segment that carries it: one of `segments`, a part or a group of parts
  /// The landmark under the marker, m, patient axes; empty: the marker's place on the segment is not known.
  std::optional<Eigen::Vector3d> point;
};

/// What a recording's points are: markers on the skin, or the joint centres of a skeleton (BVH).
enum class PointKind { markers, joints };

struct BodyMarkers {
  std::vector<BodyMarker> markers;   ///< in the order of the names
  std::vector<std::string> unknown;  ///< names without a known place, or on a segment that the body lacks
};

/// Finds markers by the names of common sets: data/marker_names.csv, for joints data/joint_names.csv. Only
/// letters and digits are compared, small and capital alike; a subject's name before a colon is left out.
/// `own` maps markers to landmarks or parts ("RTHI1 = thigh_right") and takes precedence. `segments`: those
/// of the body. If a marker's landmark is missing, its place on the segment is not known. Bones that Plug-in
/// Gait stores among the markers, four points each ("LFEO", "LFEA", "LFEL", "LFEP"), are left out.
BodyMarkers body_markers(const std::vector<std::string>& names, const Landmarks& landmarks,
                         const std::vector<std::string>& segments, PointKind kind,
                         const JointMapping& own = {});

/// What `own` may name: all landmarks and parts.
std::vector<std::string> marker_places();

}  // namespace borelli
