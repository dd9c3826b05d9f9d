// How well, and how honestly, segmentation tells the parts of scans whose truth is known.
//
// How it counts. A part is there if 5 % of its mass or more is in the scan, absent up to 0.2 %; between, it
// is not counted. Of a part that is there: *found* where half of its voxels or more carry its label,
// *swapped* where more of them carry the other side's, else *lost*, in whichever other part has most of them,
// or in none (*vanished*). A part that is absent is *absent rightly*, or *invented* if it is labelled with 20
// ml or more. A joint counts if 45 mm about it are all in the scan. Honesty: errors over stated deviations.
// Joints: each coordinate by itself, with the deviation of the truth's own reading added in squares; 68 %
// within one and 95 % within two are promised. Cuts: distance of the found plane's point from the true plane,
// against the deviation of the landmark it hangs on. Masses: of whole parts, against the table's stated
// deviation. A *bad miss* is a part that is lost, vanished, invented or swapped, or a joint missed by more
// than 5 deviations (of its distance, whose deviation is sqrt(3) of a coordinate's). It is *silent* if the
// part (of a joint: both of its parts) has a confidence of 0.5 or more and no warning names the part or
// joint.
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
  std::map<std::string, int> count;                  ///< by the words in italics above, and "joint lost"
  std::vector<double> dice, own_bone;                ///< of parts that are there
  std::vector<double> mass;                          ///< of parts there: found over true, less 1
  std::map<std::string, std::vector<double>> joint;  ///< by kind ("knee"): distance, mm
  std::vector<double> joint_honesty, cut_honesty, mass_honesty;  ///< error / stated deviation, absolute
  std::vector<Missed> missed;
  double seconds = 0;

  BodyScore& operator+=(const BodyScore& other);
};

/// Segments the scan as `borelli segment` does, weighs the parts as `borelli inertia` does, and counts.
BodyScore score_body(const TrueScan& scan, const Forest* forest = nullptr);

/// The phantom of a seed with its truth: body, pose, grid and scanner drawn by the seed.
TrueScan drawn_phantom(std::uint64_t seed);

}  // namespace borelli::suite
