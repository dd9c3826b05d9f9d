// The labels' colours as 3D Slicer reads them: a colour table beside a label map.
#pragma once

#include <string>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A line per label, "id name r g b a", 0 to 255, with the colours of palette.hpp; spaces in names become
/// '_'. Outside is transparent.
std::string colour_table(const LabelMap& labels);

/// The colour table's file for a label map: its name with the extension replaced by .ctbl.
std::string colour_file(const std::string& path);

}  // namespace borelli
