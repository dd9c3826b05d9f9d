// Points of the soles: where a foot touches the ground.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// By foot ("foot_left"): points of the skin (m, patient axes) below heel, metatarsal heads I and V and toe
/// tip, of those landmarks that are known. Down is the foot's -Y axis (segment_frames.hpp). Each point is as
/// low as the lowest voxel of the foot within 12 mm of its landmark.
using FootSoles = std::map<std::string, std::vector<Eigen::Vector3d>, std::less<>>;

/// `labels`: of the body's parts. A foot without voxels or axes is left out.
FootSoles foot_soles(const LabelMap& labels, const Landmarks& landmarks);

}  // namespace borelli
