// Another program's label map with the rule of each class. A segmentation can start from it instead of from
// bare CT numbers.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct ClassLabels {
  LabelMap labels;                    ///< classes; 0: no class
  std::vector<ClassRule> rules;       ///< by label; [0] is not used
  std::vector<std::string> warnings;  ///< from reading the labels; classes missing in the mapping

  const ClassRule& rule(std::uint8_t label) const { return rules[label]; }
};

/// Joins a label map and a mapping. Classes that the mapping lacks are treated as unlabelled, with a warning.
/// Errors: a mapping that knows none of the map's classes.
Result<ClassLabels> class_labels(const std::string& where, NumberedLabels labels,
                                 const ClassMapping& mapping);

/// Reads both. `names` as for read_labels, `mapping` as for class_mapping. If no class has a name, a ready
/// mapping must fit the classes' places (mapping_fit.hpp); the check also uses `scan`, the volume that they
/// belong to. Errors: as read_numbered_labels, class_mapping and class_labels.
Result<ClassLabels> read_classes(const std::string& path, const std::string& names,
                                 const std::string& mapping, const GreyVolume* scan = nullptr,
                                 const Progress& progress = {});

/// The label map resampled on another grid: each voxel takes the label at its centre, 0 outside the map. This
/// fits a map to its scan if it was cropped to its segments, as 3D Slicer saves it, or has another
/// resolution.
LabelMap labels_on(const LabelMap& labels, const Grid& grid, int threads = 0);

/// The labels that have voxels outside `grid`, with the share of each that lies there, 0 to 1.
std::map<std::uint8_t, double> labels_beyond(const LabelMap& labels, const Grid& grid);
/// One sentence about them; "" if there are none.
std::string in_words(const std::map<std::uint8_t, double>& beyond, const LabelMap& labels);

/// True if the voxels of `a` lie on voxels of `b`. `b` may be larger, and its axes may have another order or
/// direction: `a` is a map cropped to its segments, or saved in another orientation.
bool same_lattice(const Grid& a, const Grid& b);

/// True if both grids have the same voxels, to a hundredth of a voxel.
bool same_grid(const Grid& a, const Grid& b);

}  // namespace borelli
