// The built-in forest: segmentation/data/voxel_forest.bin as of the program's build.
#include "segmentation/proposal/class_probabilities.hpp"

extern "C" {
extern const char borelli_voxel_forest[];
extern const char borelli_voxel_forest_end[];
}

namespace borelli {

Result<Forest> ready_forest() {
  return parse_forest({borelli_voxel_forest, borelli_voxel_forest_end}, "voxel_forest.bin");
}

}  // namespace borelli
