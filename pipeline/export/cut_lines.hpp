// Where the planes that part one segment from the next run in a picture of the body seen from the front.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "pipeline/export/thumbnail.hpp"
#include "segmentation/vocabulary/cuts.hpp"

namespace borelli {

/// A cut seen from the front: its plane's line in the coronal plane through the cut's point, as far as the
/// plane parts the body (anywhere from front to back).
struct CutLine {
  std::string joint;
  Eigen::Vector3d from, to;  ///< mm, LPS; `from` is the patient's right end
};

/// A line for each cut that shows in the copy's labels: where the part beyond the plane lies on its one side
/// and the part before it on the other. Labels that were not cut by a plane have no line of it, nor has a
/// plane that lies flat in the picture. `names[label]` as in a label map.
std::vector<CutLine> cut_lines(const Thumbnail& copy, const std::vector<std::string>& names,
                               const std::vector<Cut>& cuts);

}  // namespace borelli
