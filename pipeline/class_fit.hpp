// Whether somebody else's classes lie where the scan shows their tissues: bone where it is bright, lung and
// trachea where gas is, flesh where none is.
//
// A class map of the same scan agrees best where its header puts it. One that was moved agrees better some
// way off, one that was mirrored or turned over agrees better with an axis reversed, one of another body
// agrees nowhere. Thin or thick bones, contrast medium, gas in the gut and few classes change how well it
// agrees, but not where.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "segmentation/class_map.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

struct ClassFit {
  bool judged = false;  ///< enough bone or lung is labelled and in view to tell
  double agreement =
      0;              ///< share of labelled voxels that show their tissue, 0 to 1, bone and lung before flesh
  double beside = 0;  ///< the mean after shifts by 12 mm along each axis: of another body, no worse
  double moved = 0;   ///< the best after a shift
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< that shift, mm
  double reversed = 0;  ///< the best after one axis of the label map is reversed and a shift
  int axis = -1;        ///< that axis (0 to 2)

  bool fits() const;
};

/// CT numbers or densities that stand for them (an MR's show no bone: not judged).
ClassFit class_fit(const GreyVolume& volume, const ClassMap& classes, int threads = 0);

/// A sentence for classes that do not fit; empty where they do or nothing can be told.
std::string in_words(const ClassFit& fit);

}  // namespace borelli
