// A random warp of a body and a random scanner, drawn by a seed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "samples/phantom_voxels.hpp"
#include "tests/suite/body_map.hpp"

namespace borelli::suite {

struct LabelledBody;

/// The scanned part of the body.
enum class View { whole, no_head, trunk, chest, abdomen, pelvis, legs, one_leg, head_neck, arms_and_trunk };

/// A lost limb: a part from a share of its length on, and all parts beyond it.
struct Loss {
  int part = 0;
  double from = 0;          ///< 0: the whole part
  bool artificial = false;  ///< a metal tube replaces it
};

struct Scanner {
  Eigen::Vector3d spacing{2, 2, 2};                        ///< mm
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();  ///< of the grid, as in GridOptions
  double tilt_deg = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< of the grid, voxels
  ScanOptions effects;                               ///< along k, partial volumes are always on
  View view = View::whole;
  bool left = true;      ///< of one_leg
  double shift = 0;      ///< of the view's ends along z, mm
  double gut_hu = 0;     ///< contrast agent in stomach and gut, HU
  double vessel_hu = 0;  ///< contrast agent in heart and vessels, HU
  double window_low = -1024, window_high = 3071;
  bool eight_bits = false;  ///< 256 steps over the window
};

struct Warp {
  std::uint64_t seed = 0;
  Motion motion;
  std::optional<Loss> loss;
  int metal_hip = 0;  ///< 1 left, 2 right
  Scanner scanner;
  std::vector<std::string> kinds;  ///< e.g. "arms raised", "thick slices": sorted
};

/// The scan of the body at rest: 3 mm voxels without effects.
Warp rest_warp();

/// The warp of a seed: the same seed and attempt give the same. Each further `attempt` draws another pose
/// with smaller turns, in case limbs intersect.
Warp drawn_warp(std::uint64_t seed, int attempt = 0);

}  // namespace borelli::suite
