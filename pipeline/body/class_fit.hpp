// Checks whether another program's label map belongs to a scan: voxels labelled bone must be bright, lung and
// trachea must hold gas, and soft tissue must not.
//
// A map of the same scan agrees best in the place that its header states. A shifted map agrees better after a
// shift, a mirrored one with an axis reversed, and a map of another body nowhere. Thin or thick bones,
// contrast agent, bowel gas and missing classes change how well a map agrees, but not where it agrees best.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "segmentation/files/class_labels.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct ClassFit {
  bool judged = false;  ///< enough bone or lung is labelled and in view to judge
  double agreement =
      0;  ///< mean share of voxels that show their tissue, 0 to 1; weights: bone 1, lung 1, flesh .5
  double beside = 0;                                ///< mean agreement after shifts by 12 mm along each axis
  double moved = 0;                                 ///< best agreement after a shift
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< that shift, mm
  double reversed = 0;  ///< best agreement after one axis of the label map is reversed, and a shift
  int axis = -1;        ///< that axis (0 to 2)

  bool fits() const;
};

/// `volume` holds CT numbers or densities. MR is not judged, since it does not tell bone from air.
ClassFit class_fit(const GreyVolume& volume, const ClassLabels& classes, int threads = 0);

/// Says in one sentence why the labels do not fit the scan; "" if they fit or were not judged.
std::string in_words(const ClassFit& fit);

}  // namespace borelli
