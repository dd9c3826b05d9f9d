// Probability of each class at each voxel of the body, by a forest.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/proposal/forest.hpp"
#include "segmentation/proposal/voxel_features.hpp"

namespace borelli {

/// The classes of the forest; left and right share a class.
inline constexpr std::array<std::string_view, 8> voxel_classes{"head", "trunk", "upper_arm", "forearm",
                                                               "hand", "thigh", "shank",     "foot"};
inline constexpr std::size_t voxel_class_count = voxel_classes.size();
/// Index into voxel_classes of a part of parts.hpp; -1 outside the body.
int voxel_class(int part_label);

struct ClassProbabilities {
  std::vector<std::uint8_t> shares;  ///< #CoarseBody::places by #voxel_classes, in 255ths

  const std::uint8_t* of(std::size_t place) const { return shares.data() + place * voxel_classes.size(); }
};

/// Evaluates the forest at every second voxel along each axis, then at those others whose evaluated
/// neighbours disagree or are unsure; the rest take their neighbours' mean. Errors: a forest with other
/// features or classes.
Result<ClassProbabilities> class_probabilities(const VoxelFeatures& features, const Forest& forest);

/// The forest that is built into the program. Errors: only if it was built from a damaged file.
Result<Forest> ready_forest();

}  // namespace borelli
