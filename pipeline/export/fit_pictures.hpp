// Close-ups of the bone that joint centres were measured on, for the fitted circle to be looked at upon it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A square picture about a point of a fitted sphere's centre or cylinder's axis. Pixel (u, v), v downwards,
/// shows the point middle + ((u + 1/2) / pixels - 1/2) side across + ((v + 1/2) / pixels - 1/2) side down.
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
  double side = 0;  ///< of the square, mm
  std::vector<FitPlane> planes;
};

/// Every landmark that a sphere or cylinder on bone gave (its radius is not 0): a sphere's in the coronal and
/// the axial plane, a cylinder's square to its axis, half way from its centre to either end of it
/// (JOINT_medial_SIDE and JOINT_lateral_SIDE): at the middle of a knee no condyle is, but the notch.
/// CT numbers and densities only; of an MR volume none.
std::vector<FitPicture> fit_pictures(const GreyVolume& grey, const Landmarks& landmarks);

}  // namespace borelli
