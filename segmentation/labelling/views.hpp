// Views of a scan: directions and lengths in which a body looks like an adult who lies straight.
#pragma once

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// How a volume is viewed: a body turned in the scanner along its own axes, and one of unusual size scaled to
/// an adult's. Directions and lengths of bones, gaps and flesh are tuned to an adult who lies straight.
struct View {
  double size = 1;                                     ///< of the body relative to an adult
  Eigen::Matrix3d body = Eigen::Matrix3d::Identity();  ///< its left, back and up, in the patient frame
  double turn() const { return Eigen::AngleAxisd(body).angle(); }

  Grid seen(Grid grid) const {
    grid.axes = body.transpose() * grid.axes / size;
    grid.origin = body.transpose() * grid.origin / size;
    return grid;
  }
  Landmarks seen(Landmarks landmarks) const {
    return moved(std::move(landmarks), body.transpose(), 1 / size);
  }
  Landmarks unseen(Landmarks landmarks) const { return moved(std::move(landmarks), body, size); }

 private:
  static Landmarks moved(Landmarks landmarks, const Eigen::Matrix3d& turn, double factor) {
    for (auto& [name, landmark] : landmarks) {
      landmark.point = factor * (turn * landmark.point);
      landmark.deviation *= factor, landmark.radius *= factor;
    }
    return landmarks;
  }
};

/// A body turned by more is viewed along its own axes (radians); hips and shoulders of straight bodies are up
/// to about 3 degrees off.
inline constexpr double straight_body = 6 * EIGEN_PI / 180;

/// Whether both hips and both shoulders were found.
bool has_both(const Trunk& trunk);

/// The body's left, back and up as columns, in the patient frame, from hips and shoulders (has_both()).
Eigen::Matrix3d axes_of(const Trunk& trunk);

/// Further views, given what an adult's directions and lengths found. With hips and shoulders: along the
/// found axes and at the found size if these are unusual. Else along the axes of the body's shape, and at the
/// sizes of a child and a giant if the scan may hold a whole trunk of that size.
std::vector<View> other_views(const Anatomy& a, const Trunk& trunk);

}  // namespace borelli
