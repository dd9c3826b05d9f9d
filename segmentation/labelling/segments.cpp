#include "segmentation/labelling/segments.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

// allowed segments: the name of every label, and groups whose parts are all present
std::vector<std::string> choices(std::span<const std::string> names) {
  std::vector<std::string> all;
  for (const std::string& name : names)
    if (!name.empty() && name != parts[0].name) all.push_back(name);
  const auto there = [&](std::string_view part) { return std::ranges::find(names, part) != names.end(); };
  for (const SegmentGroup& group : segment_groups)
    if (std::ranges::all_of(group.parts, there) && !there(group.name)) all.emplace_back(group.name);
  return all;
}

std::vector<std::string> words_of(std::string_view list) {
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= list.size();) {
    const auto end = std::min(list.find(',', at), list.size());
    words.emplace_back(trimmed(list.substr(at, end - at)));
    at = end + 1;
  }
  return words;
}

}  // namespace

Result<SegmentChoice> choose_segments(std::string_view list, std::span<const std::string> names) {
  SegmentChoice choice;
  if (list.empty()) return choice;
  const auto known = choices(names);
  std::map<std::string, std::string> taken;  // label name to the segment that has it
  for (const std::string& word : words_of(list)) {
    if (std::ranges::find(known, word) == known.end())
      return bad_use("--segments",
                     fmt::format("unknown segment '{}'; choose from {}", word, fmt::join(known, ", ")));
    Segment segment{word, {word}};
    if (const SegmentGroup* group = segment_group(word);
        group && std::ranges::find(names, word) == names.end())
      segment.of.assign(group->parts.begin(), group->parts.end());
    for (const std::string& label : segment.of) {
      const auto [before, fresh] = taken.emplace(label, word);
      if (fresh) continue;
      if (before->second == word)
        return bad_use("--segments", fmt::format("{} is named twice; name it once", word));
      return bad_use(
          "--segments",
          fmt::format("{} and {} share {}; name only one of them, since each voxel belongs to one segment",
                      before->second, word, label));
    }
    choice.push_back(std::move(segment));
  }
  if (names.size() + choice.size() > 256)
    return bad_use("--segments",
                   "the label map has too many labels for groups; at most 255 are possible in all");
  return choice;
}

Result<SegmentChoice> choose_segments(std::string_view list) {
  std::vector<std::string> names;
  for (const Part& part : parts) names.emplace_back(part.name);
  return choose_segments(list, names);
}

LabelMap labels_of_segments(const LabelMap& all, const SegmentChoice& choice) {
  if (choice.empty()) return all;
  LabelMap asked;
  asked.grid = all.grid;
  asked.names.assign(all.names.size(), "");
  asked.names.front() = all.names.front();
  std::array<std::uint8_t, 256> to{};
  for (const Segment& segment : choice) {
    const auto number_of = [&](const std::string& name) {
      return static_cast<std::size_t>(std::ranges::find(all.names, name) - all.names.begin());
    };
    const bool itself = segment.of.size() == 1;
    if (!itself) asked.names.emplace_back();
    const std::size_t number = itself ? number_of(segment.name) : asked.names.size() - 1;
    asked.names[number] = segment.name;
    for (const std::string& label : segment.of) to[number_of(label)] = static_cast<std::uint8_t>(number);
  }
  asked.voxels.resize(all.voxels.size());
  std::ranges::transform(all.voxels, asked.voxels.begin(), [&](std::uint8_t label) { return to[label]; });
  return asked;
}

std::vector<Part> segment_tree(std::span<const std::string> present) {
  const auto there = [&](std::string_view name) { return std::ranges::find(present, name) != present.end(); };
  const auto holder_of = [&](std::string_view part) -> std::string_view {
    for (const SegmentGroup& group : segment_groups)
      if (there(group.name) && std::ranges::find(group.parts, part) != group.parts.end()) return group.name;
    return part;
  };
  std::vector<Part> tree;
  for (std::size_t label = 1; label < parts.size(); ++label) {
    Part part = parts[label];
    if (!there(part.name)) {
      const SegmentGroup* group = segment_group(holder_of(part.name));
      if (!group || group->parts.front() != part.name) continue;
      part.name = group->name;
    }
    if (!part.parent.empty() && !there(part.parent)) part.parent = holder_of(part.parent);
    tree.push_back(part);
  }
  return tree;
}

}  // namespace borelli
