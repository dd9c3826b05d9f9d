// The table from the classes of another program's label map to body parts.
//
// As text with tabs: a header line that names the columns, then one class per line. `label` (the class's
// number), `name` or both identify the class. Names count if the label map has names, else numbers.
// `part` says where the class goes:
//   a part (thigh_left)            the whole class belongs to that part
//   several, or a group of them    the convention's cuts divide it among these; groups: thigh (both sides,
//                                  and likewise each paired part), arm, arm_left, arm_right, leg ..., trunk,
//                                  axial (head and trunk), body (all)
//   outside                        not body: a table, a coil
// `tissue` is an optional column: soft, bone, fat, lung or air. If empty, the class may hold any tissue,
// and its bones are those that the scan shows. Lines from '#' on are comments. As JSON:
// an object from label or name to part, or to {"part": ..., "tissue": ...}.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

enum class ClassTissue : std::uint8_t {
  soft,
  bone,
  fat,
  lung,
  air,
  any  ///< not said: it may hold bone, as a whole limb does
};

/// Parts as bits: 1 << label.
using PartSet = std::uint32_t;
inline constexpr PartSet all_parts = (PartSet{1} << parts.size()) - 2;
constexpr PartSet part_bit(int label) { return PartSet{1} << label; }

struct ClassRule {
  PartSet parts = all_parts;  ///< the class is divided among these; none: not body
  ClassTissue tissue = ClassTissue::any;

  bool operator==(const ClassRule&) const = default;
};

struct ClassMapping {
  struct Entry {
    std::optional<std::int64_t> label;
    std::string name;  ///< as in the table; may be empty
    ClassRule rule;
  };
  std::vector<Entry> entries;

  /// The rule for a class; null if the table lacks it. A known name decides; letter case and word separators
  /// do not matter. Otherwise the number decides, unless class and entry both have names: versions of a table
  /// may renumber the same classes.
  const ClassRule* find(std::int64_t label, std::string_view name) const;
};

/// The built-in mappings. `totalsegmentator` is version 2 of the task "total"; it also knows the names of the
/// other two TotalSegmentator mappings.
inline constexpr std::string_view ready_mappings[] = {"totalsegmentator", "totalsegmentator_v1",
                                                      "totalsegmentator_mr", "icrp110"};

/// For the help of --label-mapping.
inline constexpr const char* label_mapping_help =
    "How the classes of another program's labels map to parts: totalsegmentator, totalsegmentator_v1, "
    "totalsegmentator_mr, icrp110, or a file that lists each class with its part";

/// A built-in mapping by its name, or a file (.json, else tab-separated). Errors, each with its line or key:
/// no such file; a line without a part; an unknown part or tissue; a repeated class.
Result<ClassMapping> class_mapping(const std::string& name_or_file);

/// Lower case, with each run of other characters than letters and digits as one '_' (none at the ends). For
/// comparing names.
std::string plain_name(std::string_view name);

}  // namespace borelli
