// Lines of the cut planes between segments, in a picture of the body from the front.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "pipeline/export/thumbnail.hpp"
#include "segmentation/vocabulary/cuts.hpp"

namespace borelli {

/// A cut seen from the front: its plane's line in the coronal plane through the cut's point, as long as the
/// plane separates the two parts at any depth.
struct CutLine {
  std::string joint;
  Eigen::Vector3d from, to;  ///< mm, LPS; `from` is the patient's right end
};

/// One line for each cut that shows in the copy's labels: the part beyond the plane lies on one side, the
/// part before it on the other. No line if the labels were not cut by that plane, or if the plane is parallel
/// to the picture. `names[label]` as in a label map.
std::vector<CutLine> cut_lines(const Thumbnail& copy, const std::vector<std::string>& names,
                               const std::vector<Cut>& cuts);

}  // namespace borelli
