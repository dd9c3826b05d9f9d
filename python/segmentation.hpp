// A segmentation as Python holds it.
#pragma once

#include <string>

#include "segmentation/labelling/segment.hpp"

namespace borelli::python {

struct PartedScan {
  Segmentation found;
  std::string input, reading;  ///< the scan's name, and what its voxels hold
};

}  // namespace borelli::python
