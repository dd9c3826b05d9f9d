// The phantom as a scanner sees it: CT numbers on a grid, with labels.
#pragma once

#include <cstdint>

#include "samples/phantom.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct GridOptions {
  Eigen::Vector3d spacing{3, 3, 3};                        ///< mm
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();  ///< of the grid about patient x, then y, then z
  double tilt_deg =
      0;  ///< gantry tilt: each slice is shifted along the rows' normal by tan(tilt) of the step
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< shift of the grid, in voxels, -1 to 1
  double margin = 20;                                ///< mm of air around the body
  /// Only this box is scanned (patient frame, mm): the grid is cut to the smallest one that covers it.
  Eigen::Vector3d crop_low = Eigen::Vector3d::Constant(-1e9), crop_high = Eigen::Vector3d::Constant(1e9);
};

struct ScanOptions {
  bool table = false;    ///< a curved table top under the back
  bool blanket = false;  ///< a thick blanket that lies on the body from the chest to the feet
  /// Diameter of the scanner's round field of view about the grid's middle in each slice, mm; 0: everything
  /// is in view. Outside it voxels hold -2000 and have no label.
  double field_of_view = 0;
  /// Amplitude of the streaks that metal throws into its slices, HU, 20 mm from the metal's middle.
  double streaks_hu = 0;
  bool partial_volume = false;  ///< a voxel is the mean over 4 x 4 x 4 points, not its centre's value
  double blur_mm = 0;           ///< standard deviation of a Gaussian blur along the grid's axes
  double noise_hu = 0;          ///< standard deviation of the noise added after that, from voxel to voxel
                                ///< independent
  std::uint64_t seed = 1;       ///< of the noise
  int threads = 0;              ///< 0: as many as the machine has; the voxels do not depend on it
};

struct Scan {
  GreyVolume grey;
  LabelMap labels;  ///< the part that holds the voxel's centre
};

/// Whether a phantom can be scanned with these options; check user input with it first. Errors: a number that
/// is not finite or out of its range, by its name: spacing 0.2 to 50 mm, rotation -180 to 180 and tilt -45 to
/// 45 degrees, offset -1 to 1 voxels, margin 0 to 500 mm, blur 0 to 20 mm, noise 0 to 1000 HU.
Result<void> check_scan(const GridOptions& grid, const ScanOptions& scan);

/// The smallest grid with these options that contains the body (and the table's width if `table`) and its
/// margin. The options must pass check_scan.
Grid phantom_grid(const Phantom& phantom, const GridOptions& options, bool table = false);

/// Largest memory use of voxelise, bytes.
double bytes_of_scan(const Grid& grid, const ScanOptions& options);

/// Voxelises the phantom on any grid. The same phantom, grid and options give the same bytes.
Scan voxelise(const Phantom& phantom, const Grid& grid, const ScanOptions& options = {});

/// The blanket: half a tube, 6 mm thick, that lies on the belly and covers body and legs.
PhantomSolid phantom_blanket(const Phantom& phantom);

/// The table top: a shallow trough of shell and core along z, 3 mm behind the body's nearest point.
std::vector<PhantomSolid> phantom_table(const Phantom& phantom);

}  // namespace borelli
