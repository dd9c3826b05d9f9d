// Volumes, labels and landmarks as Python holds them.
#pragma once

#include <memory>
#include <string>

#include "python/common.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli::python {

/// A scan and the name of its file, without the folder.
struct NamedScan {
  ScannedVolume scan;
  std::string name;
};

/// Landmarks as a dict from names to borelli.Landmark, and back. None stands for no landmarks; a value may
/// also be a point (3 numbers, mm).
py::dict dict_of(const Landmarks& landmarks);
Landmarks landmarks_of(const py::object& given);

}  // namespace borelli::python
