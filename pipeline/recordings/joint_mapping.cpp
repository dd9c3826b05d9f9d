#include "pipeline/recordings/joint_mapping.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "error/nearest_name.hpp"
#include "error/printable.hpp"
#include "pipeline/recordings/text_rows.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

// The joint and the segment of a line; either may be empty.
std::pair<std::string_view, std::string_view> parted_line(std::string_view line) {
  std::size_t at = line.find('\t');
  if (at == line.npos) at = line.rfind('=');  // (a segment's name contains none)
  if (at == line.npos) at = line.find_last_of(" ");
  if (at == line.npos) return {line, {}};
  return {trimmed(line.substr(0, at)), trimmed(line.substr(at + 1))};
}

std::string suggestion(std::string_view word, const std::vector<std::string>& names) {
  const auto nearest = nearest_name(word, names);
  return nearest ? fmt::format(", did you mean '{}'?", printable(*nearest)) : "";
}

}  // namespace

const std::string* JointMapping::find(std::string_view joint) const {
  const auto found = std::ranges::find(entries, joint, &Entry::joint);
  return found == entries.end() ? nullptr : &found->segment;
}

Result<JointMapping> parse_joint_mapping(std::string_view text, const std::string& file,
                                         const std::vector<std::string>& segments) {
  JointMapping out;
  std::set<std::string, std::less<>> seen;
  TextRows rows(text);
  for (bool first = true; rows.next();) {
    const std::string_view line = trimmed(rows.line());
    if (line.empty() || line.starts_with('#')) continue;
    const auto [joint, segment] = parted_line(line);
    if (std::exchange(first, false) && lower_case(joint) == "joint" && lower_case(segment) == "segment")
      continue;
    const std::string where = fmt::format("{}:{}", file, rows.number());
    if (joint.empty() || segment.empty())
      return bad_use(where,
                     fmt::format("is '{}', expected a name and its place, as in 'LeftUpLeg = thigh_left'",
                                 printable(line)));
    if (!segments.empty() && std::ranges::find(segments, segment) == segments.end())
      return bad_use(where, fmt::format("'{}' is not a place on the body{}", printable(segment),
                                        suggestion(segment, segments)));
    if (!seen.emplace(joint).second)
      return bad_use(where, fmt::format("lists the joint '{}' twice; remove one", printable(joint)));
    out.entries.push_back({std::string(joint), std::string(segment), rows.number()});
  }
  if (out.entries.empty())
    return bad_use(file, "contains no line; expected lines like 'LeftUpLeg = thigh_left'");
  return out;
}

Result<JointMapping> read_joint_mapping(const std::filesystem::path& path,
                                        const std::vector<std::string>& segments) {
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  return parse_joint_mapping(*text, path.string(), segments);
}

Result<void> check_joints(const JointMapping& mapping, const std::vector<std::string>& joints,
                          const std::string& file) {
  const std::set<std::string_view> known(joints.begin(), joints.end());
  for (const JointMapping::Entry& entry : mapping.entries)
    if (!known.contains(entry.joint))
      return bad_use(fmt::format("{}:{}", file, entry.line),
                     fmt::format("lists '{}', which is not in the motion{}", printable(entry.joint),
                                 suggestion(entry.joint, joints)));
  return {};
}

}  // namespace borelli
