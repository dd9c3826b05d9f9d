// The suite of hard cases: bodies, poses, coverages and scanners that real scans have, made by the sample
// phantom with proportions, bones and poses of its own in each case, and what segmentation makes of them from
// grey values alone, measured against what is exactly known.
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
  std::string what;  ///< in a few words, for the table
  PhantomOptions body;
  GridOptions grid;
  ScanOptions scan;
  std::vector<std::string> touching{};  ///< parts that touch others skin to skin: 0.90 is asked of their Dice
};
inline void PrintTo(const Case& c, std::ostream* out) { *out << c.what; }

/// All cases, in the table's order.
std::vector<Case> cases();

/// Demands of each part: Dice 0.95 (0.90 of hands, feet and what touches), joint centres within 3 mm (hips
/// 1.5), masses of parts that are whole in the scan within 3 %, and parts called whole, cut or absent as they
/// are.
struct Score {
  std::array<double, parts.size()> dice{};        ///< 1 of what is nowhere
  std::array<double, parts.size()> mass_error{};  ///< of parts whole in the scan, in shares of the exact one
  std::map<std::string, double> joint_error;      ///< of joints well within the scan, mm; 999: not found
  std::vector<std::string> misses;                ///< "dice hand_left", "joint knee_right", ...: sorted
  std::vector<std::string> silent;                ///< those of them that no low confidence tells of
  std::array<bool, parts.size()> judged{}, whole{};  ///< more than a sliver of it is in the scan; all of it
  double seconds = 0;                                ///< of segmentation
};

/// Makes the scan, segments it as `borelli segment` does, and measures. Throws std::runtime_error where the
/// case cannot be made or segmentation refuses it.
Score score(const Case& asked);

}  // namespace borelli::suite
