// Close-ups of the bone that joint centres were measured on, for the fitted circle to be looked at upon it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "segmentation/landmarks.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

/// A square picture about a fitted centre. Pixel (u, v), v downwards, shows the point
/// centre + ((u + 1/2) / pixels - 1/2) side across + ((v + 1/2) / pixels - 1/2) side down.
struct FitPlane {
  std::string name;                ///< "coronal", "axial", or "across the axis"
  Eigen::Vector3d across, down;    ///< unit, patient frame (LPS)
  std::vector<std::uint8_t> grey;  ///< row by row; byte b is the CT number low + b / 255 (high - low)
};

struct FitPicture {
  static constexpr int pixels = 88;
  static constexpr double low = -200, high = 900;  ///< CT numbers
  std::string joint;
  Landmark fit;
  double side = 0;  ///< of the square, mm
  std::vector<FitPlane> planes;
};

/// Every landmark that a sphere or cylinder on bone gave (its radius is not 0): a sphere's in the coronal and
/// the axial plane, a cylinder's square to its axis, which runs from JOINT_medial_SIDE to JOINT_lateral_SIDE.
/// CT numbers and densities only; of an MR volume none.
std::vector<FitPicture> fit_pictures(const GreyVolume& grey, const Landmarks& landmarks);

}  // namespace borelli
