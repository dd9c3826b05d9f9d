// The segments that a user requests: parts by name, and groups of parts that count as one.
//
//   trunk                  lower, middle and upper trunk, as de Leva (1996) gives the whole trunk
//   arm_left, arm_right    upper arm, forearm and hand
//   leg_left, leg_right    thigh, shank and foot
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct SegmentGroup {
  std::string_view name;
  std::array<std::string_view, 3> parts;  ///< the first joins the rest of the body
};

inline constexpr std::array<SegmentGroup, 5> segment_groups{{
    {"trunk", {"lower_trunk", "middle_trunk", "upper_trunk"}},
    {"arm_left", {"upper_arm_left", "forearm_left", "hand_left"}},
    {"arm_right", {"upper_arm_right", "forearm_right", "hand_right"}},
    {"leg_left", {"thigh_left", "shank_left", "foot_left"}},
    {"leg_right", {"thigh_right", "shank_right", "foot_right"}},
}};

/// A group by its name; null if there is none.
constexpr const SegmentGroup* segment_group(std::string_view name) {
  for (const SegmentGroup& group : segment_groups)
    if (group.name == name) return &group;
  return nullptr;
}

/// Whether a name is a part's or a group's.
constexpr bool is_segment(std::string_view name) { return part_label(name) > 0 || segment_group(name); }

/// A requested segment.
struct Segment {
  std::string name;
  std::vector<std::string> of;  ///< names of its labels: its own, or its group's parts
};
/// In the order of the request; empty: every label as it is.
using SegmentChoice = std::vector<Segment>;

/// Help text of `--segments`.
inline constexpr const char* segments_help =
    "Segments to measure, separated by commas: parts by name, or trunk, arm_left, arm_right, leg_left, "
    "leg_right, which merge their parts (default: every part)";

/// Parses a list such as "trunk,thigh_left". `names`: the names of a label map (default: the sixteen parts).
/// Groups are allowed if all of their parts are in `names`. An empty list is an empty choice. Errors: an
/// unknown name (the message lists the known ones), a repeated name, a part together with its group.
Result<SegmentChoice> choose_segments(std::string_view list, std::span<const std::string> names);
Result<SegmentChoice> choose_segments(std::string_view list);

/// A label map of the requested segments only. Parts and other labels keep their number; groups get numbers
/// after the last name's, in the order of the request. Without a choice, the map as it is.
LabelMap labels_of_segments(const LabelMap& all, const SegmentChoice& choice);

/// The segments in `present` (names of parts and groups) as a tree, in the order of `parts`; a group stands
/// at its first part. Each segment's parent is the segment that contains its part's parent. Other names are
/// left out.
std::vector<Part> segment_tree(std::span<const std::string> present);

}  // namespace borelli
