// Writes the labels' colours beside a label map, as a colour table of 3D Slicer.
#pragma once

#include <string>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// One line per label, "id name r g b a", 0 to 255, with the colours of palette.hpp. Spaces in names become
/// '_'. Outside is transparent.
std::string colour_table(const LabelMap& labels);

/// The colour table's file for a label map: its name with the extension replaced by .ctbl.
std::string colour_file(const std::string& path);

}  // namespace borelli
