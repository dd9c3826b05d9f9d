// Whether what was read can be a scan of a person: asked in one place, of every reader's answer.
//
// What is certainly wrong is refused, what is doubtful is said. CT numbers are judged by where air (-1000)
// and soft tissue (-200 to 200) should be. Partial scans, children, MR and densities pass.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/quantity.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

/// How many voxels lie where something is told by.
struct ValueCounts {
  std::int16_t least = 0, greatest = 0;  ///< with what stands for voxels that were not seen
  /// The rest of CT numbers only.
  std::int64_t seen = 0;
  std::int64_t below_tissue = 0;   ///< below -200: air, lungs
  std::int64_t soft = 0;           ///< -200 to 200
  std::int64_t near_zero = 0;      ///< -76 to 124: air, where 1000 or 1024 was added
  std::int64_t raised = 0;         ///< 824 to 1224: soft tissue then
  std::int64_t beside_raised = 0;  ///< 424 to 823 and above 1224: hardly anything then, else as much as there
  std::int64_t wrapped = 0;        ///< air's -1024 to -900 as unsigned numbers of 12 to 15 bits
};
ValueCounts count_values(const GreyVolume& volume);

/// Of a volume as it was read from `path`. What is doubtful is added to `warnings`. Errors: CT numbers that
/// cannot be right, with the likely cause.
Result<void> check_values(const std::string& path, const GreyVolume& volume, const ValueCounts& counts,
                          const Clamped& clamped, std::vector<std::string>& warnings);

/// What is doubtful about the voxels' size; empty where nothing is.
std::string doubt_of_size(const Grid& grid);

/// What is doubtful about a body of which no part is cut or missing; empty where nothing is. `mass` in kg, 0
/// where it is not known; `volume` in m^3.
std::string doubt_of_body(double volume, double mass = 0);

}  // namespace borelli
