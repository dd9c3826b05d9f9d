// Scores segmentation on scans with known truth: correctness, and honesty of stated deviations.
//
// Counting. A part is present if at least 5 % of its mass is in the scan, absent up to 0.2 %, and not counted
// in between. A present part is *found* if at least half of its voxels have its label, *swapped* if most have
// the other side's, else *lost* (most voxels in another part) or *vanished* (most voxels in none). An absent
// part is *absent rightly*, or *invented* if at least 20 ml are labelled. A joint counts if a ball of 45 mm
// around it is in the scan. Honesty: errors over stated deviations. Joints: per coordinate, with the truth's
// deviation added in squares; 68 % should lie within one deviation and 95 % within two. Cuts: distance of the
// found plane's point from the true plane, over the deviation of its landmark. Masses: of whole parts, over
// the table's deviation. Landmarks count as joints do. A *bad miss* is a part that is lost, vanished, invented
// or swapped, or a joint off by more than 5 deviations of its distance (sqrt(3) times a coordinate's
// deviation). It is *silent* if the part (for a joint: both its parts) has a confidence of at least 0.5 and no
// warning names the part or joint.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/suite/true_scan.hpp"

namespace borelli::suite {

struct Missed {
  std::string what;  ///< e.g. "swapped hand_left", "joint knee_right by 44 mm (stated 3)"
  bool silent = false;
};

/// Counts and errors of one scan, or of many.
struct BodyScore {
  int scans = 0, refused = 0;
  std::map<std::string, int> count;    ///< by the italic words above, and "joint lost"
  std::vector<double> dice, own_bone;  ///< of present parts
  std::vector<double> mass;            ///< of present parts: found over true mass, minus 1
  std::vector<double> joint_honesty, cut_honesty, mass_honesty;  ///< error / stated deviation, absolute
  std::map<std::string, std::vector<double>> landmark;           ///< by kind ("knee"): distance, mm
  std::map<std::string, std::vector<double>> landmark_honesty;   ///< by kind: as joint_honesty
  std::vector<Missed> missed;
  double seconds = 0;

  BodyScore& operator+=(const BodyScore& other);
};

/// Segments the scan as `borelli segment` does, weighs the parts as `borelli inertia` does, and counts.
BodyScore score_body(const TrueScan& scan, const Forest* forest = nullptr);

/// The phantom of a seed with its truth: body, pose, grid and scanner drawn by the seed.
TrueScan drawn_phantom(std::uint64_t seed);

}  // namespace borelli::suite
