// The suite of hard cases: bodies, poses, coverages and scanners as in real scans, made from the sample
// phantom with different proportions, bones and poses. Segmentation from grey values is compared with the
// exact truth.
#pragma once

#include <array>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli::suite {

struct Case {
  std::string name;
  std::string what;  ///< a short description for the table
  PhantomOptions body;
  GridOptions grid;
  ScanOptions scan;
  std::vector<std::string> touching{};  ///< parts that touch others skin to skin, whose Dice must be 0.90
};
inline void PrintTo(const Case& c, std::ostream* out) { *out << c.what; }

/// All cases, in the table's order.
std::vector<Case> cases();

/// Demands on each part: Dice 0.95 (0.90 for hands, feet and touching parts), joint centres within 3 mm (hips
/// 1.5), masses of whole parts within 3 %, and the right coverage (whole, cut or absent).
struct Score {
  std::array<double, parts.size()> dice{};           ///< 1 for absent parts
  std::array<double, parts.size()> mass_error{};     ///< of whole parts, relative to the exact mass
  std::map<std::string, double> joint_error;         ///< for joints well within the scan, mm; 999: not found
  std::vector<std::string> misses;                   ///< "dice hand_left", "joint knee_right", ...: sorted
  std::vector<std::string> silent;                   ///< misses without a low confidence
  std::array<bool, parts.size()> judged{}, whole{};  ///< more than a sliver, or all, of it is in the scan
  double seconds = 0;                                ///< of segmentation
};

/// Makes the scan, segments it as `borelli segment` does, and scores it. Throws std::runtime_error if the
/// case cannot be made or segmentation refuses it.
Score score(const Case& asked);

}  // namespace borelli::suite
