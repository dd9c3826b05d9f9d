// Which body parts the classes of somebody else's label map belong to: a table from class to part.
//
// As text with tabs: a header line that names the columns, then a class a line. `label` (the class's number)
// or `name` or both tell the class; where the label map has names they count, else the numbers. `part` is
// where it goes:
//   a part (thigh_left)            the whole class is that part's
//   several, or a group of them    it is divided among these by the convention's cuts; groups: thigh (both
//                                  sides, and so for each paired part), arm, arm_left, arm_right, leg ...,
//                                  trunk, axial (head and trunk), body (all)
//   outside                        no body: a table, a coil
// `tissue`, if there is such a column: soft, bone, fat, lung or air; where it is not said, the class may hold
// any, and its bones are those that the scan shows. Lines from '#' on are comments. As JSON:
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
  PartSet parts = all_parts;  ///< among which the class is divided; none: it is no body
  ClassTissue tissue = ClassTissue::any;

  bool operator==(const ClassRule&) const = default;
};

struct ClassMapping {
  struct Entry {
    std::optional<std::int64_t> label;
    std::string name;  ///< as it stands in the table; may be empty
    ClassRule rule;
  };
  std::vector<Entry> entries;

  /// The rule for a class, by its name where it has one that is known (letters' case and what separates words
  /// do not matter), else by its number, if not both have names: versions of a table may number the same
  /// classes anew. Nothing where the table does not tell of it.
  const ClassRule* find(std::int64_t label, std::string_view name) const;
};

/// The mappings that need no file. `totalsegmentator` is version 2 of its task "total", and knows the names
/// of the other two as well.
inline constexpr std::string_view ready_mappings[] = {"totalsegmentator", "totalsegmentator_v1",
                                                      "totalsegmentator_mr", "icrp110"};

/// For the help of --label-mapping.
inline constexpr const char* label_mapping_help =
    "The labels are another program's classes. Their parts are told by: totalsegmentator, "
    "totalsegmentator_v1, "
    "totalsegmentator_mr, icrp110, or a table from class to part";

/// One of the ready ones by its name, or a file (.json, else tabs). Errors: no such file; a line without
/// part, a part or tissue that is none, a class twice, each with its line or key.
Result<ClassMapping> class_mapping(const std::string& name_or_file);

/// Small letters, with anything else than letters and digits as one '_' (none at the ends): names to compare.
std::string plain_name(std::string_view name);

}  // namespace borelli
