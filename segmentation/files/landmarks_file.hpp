// Landmarks as a JSON file that a person can read, correct and hand back.
//
//   {"frame": "LPS", "unit": "mm",
//    "landmarks": {"hip_left": {"point": [x, y, z], "deviation": 2.0, "radius": 24.1, "source": "bone: ..."},
//    ...}}
#pragma once

#include <string>

#include "error/error.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

/// Writes to the path given. Errors: not writable, disk full.
Result<void> write_landmarks(const std::string& path, const Landmarks& landmarks);

/// Reads such a file; deviation, radius and source may be missing (0, 0, "given"). Frame RAS is converted to
/// LPS. Errors: missing file, not JSON (with line and column), a landmark without three finite numbers, an
/// unknown frame or unit.
Result<Landmarks> read_landmarks(const std::string& path);

}  // namespace borelli
