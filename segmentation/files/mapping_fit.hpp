// Whether a ready mapping's class names fit the places of a label map's numbers.
//
// Versions of a table number the same classes anew. Where a file has numbers alone, the wrong version's table
// gives names that no body has in those places: a femur above the skull, a bone of air. Each class with a
// known place in the body (data/anatomy.tsv) is held against the others: what lies above what, its side, its
// volume, and what the scan shows there.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/read.hpp"

namespace borelli {

/// Where a number's voxels lie, and what the scan shows there.
struct NumberPlace {
  std::int64_t number = 0;
  double volume_ml = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mm, LPS
  /// Shares of its voxels over 150 HU and below -300 HU; negative: no CT numbers are known.
  double bright = -1, gas = -1;
};

/// The places of all numbers of a map. `scan`: the CT of the same body on any grid; nullptr or MR: none.
std::vector<NumberPlace> places_of(const NumberedLabels& labels, const GreyVolume* scan);

struct MappingFit {
  std::size_t judged = 0;              ///< classes that something can be said of, and unknown numbers
  std::vector<std::string> misplaced;  ///< those of them that lie where no body has them
  double share() const {
    return judged ? static_cast<double>(misplaced.size()) / static_cast<double>(judged) : 0;
  }
};

/// How a mapping's names fit these places. Of a header that mirrors the body or turns it over, the best of
/// these four readings counts: others warn of that.
MappingFit fit_of(const std::vector<NumberPlace>& places, const ClassMapping& mapping);

/// The ready mapping to read numbers without names by: `name` itself where it fits, or another version of
/// the same program's classes where that one does, with a sentence in `warnings` that names both. Errors:
/// none of them fits.
Result<ClassMapping> fitting_mapping(const std::string& where, const std::string& name,
                                     const std::vector<NumberPlace>& places,
                                     std::vector<std::string>& warnings);

}  // namespace borelli
