// Checks whether a built-in mapping's class names fit the places of a label map's numbers.
//
// Versions of a table renumber the same classes. If a file has only numbers, the wrong version's table gives
// impossible names: a femur above the skull, a bone of air. Each class with a known place in the body
// (data/anatomy.tsv) is compared with the others: vertical order, side, volume, and CT numbers there.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {

/// Position of a number's voxels, and what the scan shows there.
struct NumberPlace {
  std::int64_t number = 0;
  double volume_ml = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mm, LPS
  /// Shares of its voxels above 150 HU and below -300 HU; negative: no CT numbers.
  double bright = -1, gas = -1;
};

/// The places of all numbers of a map. `scan`: the CT of the same body on any grid; nullptr or MR: not used.
std::vector<NumberPlace> places_of(const NumberedLabels& labels, const GreyVolume* scan);

struct MappingFit {
  std::size_t judged = 0;              ///< classes that could be checked, and unknown numbers
  std::vector<std::string> misplaced;  ///< those in an impossible place
  double share() const {
    return judged ? static_cast<double>(misplaced.size()) / static_cast<double>(judged) : 0;
  }
};

/// Checks a mapping's names against these places. A header may mirror the body or turn it upside down: the
/// best of the four readings counts. Other checks warn of such headers.
MappingFit fit_of(const std::vector<NumberPlace>& places, const ClassMapping& mapping);

/// The built-in mapping for numbers without names: `name` if it fits, else a version of the same program's
/// classes that fits, with a sentence in `warnings` that names both. Errors: none fits.
Result<ClassMapping> fitting_mapping(const std::string& where, const std::string& name,
                                     const std::vector<NumberPlace>& places,
                                     std::vector<std::string>& warnings);

}  // namespace borelli
