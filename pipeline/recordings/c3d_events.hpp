// The events of a C3D file: those of its header and those of its EVENT group.
// Source: C3D user guide, "Header events" and "The EVENT Group", www.c3d.org.
#pragma once

#include <string_view>
#include <vector>

#include "pipeline/recordings/c3d_file.hpp"
#include "pipeline/recordings/c3d_layout.hpp"

namespace borelli {

/// All events in the order of their times. The header counts seconds from the first frame, EVENT:TIMES
/// (minutes and seconds) from frame number 1. An event of the header that stands in the EVENT group too comes
/// once. `bytes`: the file, of at least 512 bytes.
std::vector<MotionEvent> c3d_events(std::string_view bytes, C3dProcessor processor,
                                    const C3dParameters& parameters, const C3dLayout& layout,
                                    std::vector<std::string>& warnings);

}  // namespace borelli
