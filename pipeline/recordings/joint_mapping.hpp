// A table from another program's joint names to our segment names, as text.
//
//   # Mixamo to the body's segments
//   joint           segment
//   mixamorig:Hips  lower_trunk
//   LeftUpLeg = thigh_left
//
// A line is a joint and a segment with a tab or an equal sign between them, or the last blanks if there is
// neither; so joint names may hold blanks. '#' at the start of a line begins a comment. A first line "joint
// segment" is a heading.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct JointMapping {
  struct Entry {
    std::string joint, segment;
    int line = 0;  ///< in the file
  };
  std::vector<Entry> entries;  ///< in the order of the file

  /// The segment of a joint; null if the table lacks it.
  const std::string* find(std::string_view joint) const;
};

/// Reads such a table. Several joints may go to one segment. Errors, with their line: a line without both
/// names; a joint twice; a segment that is none of `segments` (empty: any), naming the nearest; no line.
Result<JointMapping> read_joint_mapping(const std::filesystem::path& path,
                                        const std::vector<std::string>& segments = {});
Result<JointMapping> parse_joint_mapping(std::string_view text, const std::string& file,
                                         const std::vector<std::string>& segments = {});

/// Checks that each joint of the table is one of `joints`. Error: with the line, naming the nearest.
Result<void> check_joints(const JointMapping& mapping, const std::vector<std::string>& joints,
                          const std::string& file);

}  // namespace borelli
