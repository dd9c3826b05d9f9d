// Close-up pictures of the bone surfaces that joint centres were fitted to, for checking the fitted circles.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A square picture about a fitted sphere's centre or a point of a fitted cylinder's axis. Pixel (u, v), v
/// downwards, shows the point middle + ((u + 1/2) / pixels - 1/2) side across + ((v + 1/2) / pixels - 1/2)
/// side down.
struct FitPlane {
  std::string name;                ///< "coronal" and "axial", or "medial" and "lateral"
  Eigen::Vector3d middle;          ///< mm, LPS
  Eigen::Vector3d across, down;    ///< unit, patient frame (LPS)
  std::vector<std::uint8_t> grey;  ///< row by row; byte b is the CT number low + b / 255 (high - low)
};

struct FitPicture {
  static constexpr int pixels = 88;
  static constexpr double low = -200, high = 900;  ///< CT numbers
  std::string joint;
  Landmark fit;
  double side = 0;  ///< edge of the square, mm
  std::vector<FitPlane> planes;
};

/// Pictures of every landmark fitted by a sphere or cylinder on bone (its radius is not 0). A sphere is shown
/// in the coronal and the axial plane. A cylinder is shown normal to its axis, half way from its centre to
/// either end (JOINT_medial_SIDE and JOINT_lateral_SIDE): the middle of a knee shows the notch, not a
/// condyle. Only for CT numbers and densities; none for an MR volume.
std::vector<FitPicture> fit_pictures(const GreyVolume& grey, const Landmarks& landmarks);

}  // namespace borelli
