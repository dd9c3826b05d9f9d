// The sixteen body parts, their labels, and the joints between them.
//
// Segments after de Leva (1996) J Biomech 29:1223: head with neck, three trunk parts, and three for each arm
// and leg.
#pragma once

#include <array>
#include <string_view>

namespace borelli {

struct Part {
  std::string_view name;    ///< e.g. "thigh_left"; its label in a label map is its index in `parts`
  std::string_view parent;  ///< its parent in the body's tree; empty for the root (lower trunk)
  std::string_view
      joint;  ///< the joint to its parent, e.g. "hip_left"; also that joint centre's landmark name
};

/// parts[label]; parts[0] is everything outside the body.
inline constexpr std::array<Part, 17> parts{{
    {"outside", "", ""},
    {"head", "upper_trunk", "neck"},
    {"upper_trunk", "middle_trunk", "spine_upper"},
    {"middle_trunk", "lower_trunk", "spine_lower"},
    {"lower_trunk", "", ""},
    {"upper_arm_left", "upper_trunk", "shoulder_left"},
    {"upper_arm_right", "upper_trunk", "shoulder_right"},
    {"forearm_left", "upper_arm_left", "elbow_left"},
    {"forearm_right", "upper_arm_right", "elbow_right"},
    {"hand_left", "forearm_left", "wrist_left"},
    {"hand_right", "forearm_right", "wrist_right"},
    {"thigh_left", "lower_trunk", "hip_left"},
    {"thigh_right", "lower_trunk", "hip_right"},
    {"shank_left", "thigh_left", "knee_left"},
    {"shank_right", "thigh_right", "knee_right"},
    {"foot_left", "shank_left", "ankle_left"},
    {"foot_right", "shank_right", "ankle_right"},
}};

/// Label of a part by its name; 0 if there is no such part.
constexpr int part_label(std::string_view name) {
  for (std::size_t label = 1; label < parts.size(); ++label)
    if (parts[label].name == name) return static_cast<int>(label);
  return 0;
}

/// Whether a part is the head or a trunk part.
constexpr bool is_axial(int label) {
  return label >= part_label("head") && label <= part_label("lower_trunk");
}

}  // namespace borelli
