#include "pipeline/motion/body_markers.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <sstream>

#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace data {
extern const char* const marker_names;
extern const char* const joint_names;
}  // namespace data

namespace {

/// A place of the table, with its side.
struct MarkerPlace {
  std::string landmark, segment;  ///< landmark: empty, one, or two joined by '+', whose middle it is
};

/// Without the subject's name, in small letters and digits.
std::string plain_name(std::string_view name) {
  if (const auto colon = name.rfind(':'); colon != name.npos) name.remove_prefix(colon + 1);
  std::string out;
  for (const unsigned char c : name)
    if (std::isalnum(c)) out += char(std::tolower(c));
  return out;
}

std::string sided(std::string text, std::string_view side) {
  if (text.ends_with('*')) {
    text.pop_back();
    // the trunk and the head have no sides
    const bool midline = text == "lower_trunk" || text == "upper_trunk" || text == "head";
    if (!midline) text += "_" + std::string(side);
  }
  return text;
}

struct NameTable {
  std::map<std::string, MarkerPlace, std::less<>> by_name;
  std::map<std::string, std::string, std::less<>> segment_of_landmark;
};

NameTable read_table(const char* text) {
  NameTable table;
  std::istringstream lines(text);
  bool heading = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    if (std::exchange(heading, false)) continue;
    std::istringstream cells(line);
    std::string landmark, segment, names;
    std::getline(cells, landmark, ','), std::getline(cells, segment, ','), std::getline(cells, names);
    if (landmark == "-") landmark.clear();
    const bool has_side = landmark.ends_with('*') || segment.ends_with('*');
    std::istringstream words(names);
    for (std::string word; words >> word;) {
      if (!has_side) {
        table.by_name.emplace(word, MarkerPlace{landmark, segment});
        continue;
      }
      for (const std::string_view side : {"left", "right"}) {
        const MarkerPlace place{sided(landmark, side), sided(segment, side)};
        for (const std::string_view mark : {side.substr(0, 1), side})
          for (const std::string& name : {std::string(mark) + word, word + std::string(mark)})
            table.by_name.emplace(name, place);
      }
    }
    if (landmark.empty() || landmark.find('+') != landmark.npos) continue;
    for (const std::string_view side : {"left", "right"})
      table.segment_of_landmark[sided(landmark, side)] = sided(segment, side);
  }
  return table;
}

const NameTable& name_table(PointKind kind) {
  static const NameTable markers = read_table(data::marker_names), joints = read_table(data::joint_names);
  return kind == PointKind::markers ? markers : joints;
}

/// The segment of the body that holds a part: itself or its group; empty if the body lacks it.
std::string holder_of(const std::string& part, const std::vector<std::string>& segments) {
  const auto has = [&](std::string_view name) { return std::ranges::find(segments, name) != segments.end(); };
  if (has(part)) return part;
  for (const SegmentGroup& group : segment_groups)
    if (std::ranges::find(group.parts, part) != group.parts.end() && has(group.name))
      return std::string(group.name);
  return {};
}

std::optional<Eigen::Vector3d> point_of(const std::string& landmark, const Landmarks& landmarks) {
  const auto plus = landmark.find('+');
  if (plus != landmark.npos) {
    const auto one = point_of(landmark.substr(0, plus), landmarks),
               other = point_of(landmark.substr(plus + 1), landmarks);
    if (!one || !other) return std::nullopt;
    return (*one + *other) / 2;
  }
  const auto found = landmarks.find(landmark);
  if (found == landmarks.end()) return std::nullopt;
  return 1e-3 * found->second.point;
}

std::optional<MarkerPlace> place_of(const std::string& name, PointKind kind, const JointMapping& own) {
  if (const std::string* given = own.find(name)) {
    if (part_label(*given) > 0) return MarkerPlace{"", *given};
    const auto& segments = name_table(PointKind::markers).segment_of_landmark;
    if (const auto segment = segments.find(*given); segment != segments.end())
      return MarkerPlace{*given, segment->second};
  }
  const auto& names = name_table(kind).by_name;
  const auto found = names.find(plain_name(name));
  if (found == names.end()) return std::nullopt;
  return found->second;
}

/// The origin and three axis points of a bone that Plug-in Gait computed: "PELO", "PELA", "PELL", "PELP".
std::set<std::string> computed_bones(const std::vector<std::string>& names) {
  const std::set<std::string> all(names.begin(), names.end());
  std::set<std::string> out;
  for (const std::string& name : names) {
    if (!name.ends_with('O')) continue;
    const std::string bone = name.substr(0, name.size() - 1);
    if (all.contains(bone + 'A') && all.contains(bone + 'L') && all.contains(bone + 'P'))
      for (const char end : {'O', 'A', 'L', 'P'}) out.insert(bone + end);
  }
  return out;
}

}  // namespace

BodyMarkers body_markers(const std::vector<std::string>& names, const Landmarks& landmarks,
                         const std::vector<std::string>& segments, PointKind kind, const JointMapping& own) {
  BodyMarkers out;
  const std::set<std::string> computed = computed_bones(names);
  for (const std::string& name : names) {
    if (computed.contains(name) && !own.find(name)) continue;
    const auto place = place_of(name, kind, own);
    const std::string segment = place ? holder_of(place->segment, segments) : "";
    if (segment.empty())
      out.unknown.push_back(name);
    else
      out.markers.push_back({name, segment, point_of(place->landmark, landmarks)});
  }
  return out;
}

std::vector<std::string> marker_places() {
  std::vector<std::string> out;
  for (const auto& [landmark, segment] : name_table(PointKind::markers).segment_of_landmark)
    out.push_back(landmark);
  for (std::size_t label = 1; label < parts.size(); ++label) out.emplace_back(parts[label].name);
  return out;
}

}  // namespace borelli
