// Trials of landmarks' stated deviations: bodies of 1.25 to 2.0 m on slices of any thickness, drawn by a seed
// and segmented from grey values; every landmark is compared with the exact one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli::suite {

struct TriedLandmark {
  std::string name;
  Eigen::Vector3d error;  ///< found minus exact, mm, LPS
  double deviation = 0;   ///< as stated, mm
  std::string source;
};

struct LandmarkTrial {
  double stature_m = 0;
  std::vector<TriedLandmark> landmarks;           ///< found landmarks
  std::vector<std::string> lost;                  ///< joint centres not found
  std::array<double, parts.size()> mass_error{};  ///< by label, relative to the exact mass
  std::vector<std::string> warnings;
};

/// The body of a seed on voxels of 2 x 2 x `slice` mm, with its blur and noise. Throws std::runtime_error
/// where it cannot be made or is refused.
LandmarkTrial try_landmarks(std::uint64_t seed, double slice);

/// "knee" of knee_left; a name without a side is its own stem.
std::string stem_of(const std::string& name);

}  // namespace borelli::suite
