// The scanner of a warped body: its grid, its view of the body, and surrounding objects.
#pragma once

#include <vector>

#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"
#include "tests/suite/warp.hpp"

namespace borelli::suite {

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = Eigen::Vector3d::Constant(-1e9);
  void hold(const Eigen::Vector3d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
};

/// The box that a view shows of a body with these (moved) landmarks, patient frame, mm; 1e9: unlimited.
Box view_box(const Scanner& scanner, const Landmarks& landmarks);

/// The scan's grid: it contains the body's corners and 15 mm of air, clipped to the view.
Grid scan_grid(const Scanner& scanner, const Landmarks& landmarks,
               const std::vector<Eigen::Vector3f>& corners);

/// A grid of cubes along the patient's axes that contains all corners.
Grid cube_grid(const std::vector<Eigen::Vector3f>& corners, double step);

/// Table top (a trough of 24 mm, 3 mm behind the body) and blanket (6 mm) as CT numbers at points in air.
class Surroundings {
 public:
  Surroundings(const ScanOptions& options, const std::vector<Eigen::Vector3f>& corners, double blanket_top);
  int hu(const Eigen::Vector3d& point) const;

 private:
  bool table_, blanket_;
  double middle_ = 0, axis_y_ = -1e9, back_ = 0, deep_ = 0, top_ = 0;
};

}  // namespace borelli::suite
