#include "segmentation/files/given_landmarks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "error/json_text.hpp"
#include "error/printable.hpp"
#include "process/input_file.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/header_text.hpp"
#include "segmentation/files/landmarks_file.hpp"

namespace borelli {
namespace {

using nlohmann::json;

// default deviation of a point set by hand, mm
constexpr double by_hand = 3;
const std::string placed = "placed by hand";

// the words of a name, sorted: equal for "Hip-Left", "leftHip" and "hip l"
std::vector<std::string> words_of(std::string_view name) {
  std::string spaced;
  for (std::size_t n = 0; n < name.size(); ++n) {
    // a capital after a lower-case letter begins a word
    if (n > 0 && name[n] >= 'A' && name[n] <= 'Z' && name[n - 1] >= 'a' && name[n - 1] <= 'z') spaced += ' ';
    spaced += name[n];
  }
  std::vector<std::string> words;
  const std::string plain = plain_name(spaced) + "_";
  for (std::size_t at = 0, end; (end = plain.find('_', at)) != std::string::npos; at = end + 1) {
    const std::string word = plain.substr(at, end - at);
    if (!word.empty()) words.push_back(word == "l" ? "left" : word == "r" ? "right" : word);
  }
  std::ranges::sort(words);
  return words;
}

// What write_markups notes with a point: "bone: ...; deviation 1.5 mm; radius 24.1 mm; found at 1 2 3".
struct Note {
  std::string source;
  double deviation = 0, radius = 0;
  bool found = false;                    // found by a run; else given
  std::optional<Eigen::Vector3d> place;  // LPS, mm
};

struct Point {
  std::string name;
  Eigen::Vector3d place;
  Note note;
  bool set = true;  // false: its place is not defined yet
};

Result<GivenLandmarks> as_landmarks(const std::string& path, const std::vector<Point>& points) {
  GivenLandmarks out;
  std::string strange, unset;
  for (const Point& point : points) {
    const std::string name = landmark_of(point.name);
    auto& list = name.empty() ? strange : unset;
    if (name.empty() || !point.set) {
      list += (list.empty() ? "" : ", ") + (point.name.empty() ? "(no name)" : point.name);
      continue;
    }
    if (out.landmarks.contains(name) || out.unmoved.contains(name))
      return failure(path, "contains two points named " + name);
    const Note& note = point.note;
    const bool moved = !note.place || (*note.place - point.place).norm() > 0.01;
    (moved || !note.found ? out.landmarks : out.unmoved)[name] =
        moved ? Landmark{point.place, by_hand, note.radius, placed}
              : Landmark{*note.place, note.deviation, note.radius, note.source};
  }
  if (!strange.empty())
    out.warnings.push_back(path +
                           ": ignored points whose names are not landmarks: " + printable(strange, 200));
  if (!unset.empty())
    out.warnings.push_back(path + ": ignored points that have no position: " + printable(unset, 200));
  if (out.landmarks.empty() && out.unmoved.empty())
    return failure(
        path, "contains no point with a landmark's name (hip_left, knee_right, neck ...) and a position" +
                  (strange.empty() ? "" : "; found: '" + printable(strange, 200) + "'"));
  return out;
}

Note read_note(const std::string& text) {
  // the `count` numbers after a word; fewer if the text has fewer
  const auto numbers_after = [&](std::string_view word, std::size_t count) {
    std::vector<double> numbers;
    const auto at = text.find(word);
    if (at == std::string::npos) return numbers;
    const char *next = text.data() + at + word.size(), *end = text.data() + text.size();
    double number = 0;
    while (numbers.size() < count) {
      while (next < end && *next == ' ') ++next;
      const auto [rest, wrong] = std::from_chars(next, end, number);
      if (wrong != std::errc() || !std::isfinite(number)) break;
      numbers.push_back(number), next = rest;
    }
    return numbers;
  };
  Note note;
  note.source = text.substr(0, text.find(';'));
  if (const auto deviation = numbers_after("deviation ", 1); !deviation.empty())
    note.deviation = std::max(0., deviation[0]);
  if (const auto radius = numbers_after("radius ", 1); !radius.empty()) note.radius = std::max(0., radius[0]);
  note.found = text.find("found at ") != std::string::npos;
  if (const auto place = numbers_after(note.found ? "found at " : "given at ", 3); place.size() == 3)
    note.place = Eigen::Vector3d(place[0], place[1], place[2]);
  return note;
}

Result<GivenLandmarks> read_markups(const std::string& path, const json& document) {
  std::vector<Point> points;
  for (const json& list : document.at("markups")) {
    const auto text = [](const json& object, const char* key, const char* otherwise) {
      return object.is_object() && object.contains(key) && object[key].is_string()
                 ? object[key].get<std::string>()
                 : std::string(otherwise);
    };
    const std::string frame = text(list, "coordinateSystem", "LPS"),
                      unit = text(list, "coordinateUnits", "mm");
    if (frame != "LPS" && frame != "RAS")
      return failure(path, "coordinateSystem is \"" + printable(frame) + "\"; expected LPS or RAS");
    if (unit != "mm" && unit != "[\"mm\", \"UCUM\", \"millimeter\"]")
      return failure(path, "coordinateUnits is \"" + printable(unit) + "\"; expected mm");
    if (!list.is_object() || !list.contains("controlPoints") || !list["controlPoints"].is_array()) continue;
    for (const json& entry : list["controlPoints"]) {
      Point point{text(entry, "label", ""), {}, read_note(text(entry, "description", "")), true};
      const std::string status = text(entry, "positionStatus", "defined");
      point.set = status == "defined";
      if (point.set) {
        const json place = entry.is_object() ? entry.value("position", json()) : json();
        if (!place.is_array() || place.size() != 3 ||
            !std::ranges::all_of(place, [](const json& c) { return c.is_number(); }))
          return failure(path, "point \"" + printable(point.name) +
                                   "\": expected \"position\": [x, y, z], three numbers in mm");
        for (std::size_t c = 0; c < 3; ++c)
          point.place[static_cast<Eigen::Index>(c)] = place[c].get<double>();
        if (!point.place.allFinite())
          return failure(path, "point " + point.name + ": its position is not finite");
        if (frame == "RAS") point.place.head<2>() *= -1;
      }
      points.push_back(std::move(point));
    }
  }
  return as_landmarks(path, points);
}

// CSV fields: commas inside quotes do not separate; two quotes stand for one
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t n = 0; n < line.size(); ++n) {
    const char c = line[n];
    if (c == '"' && quoted && n + 1 < line.size() && line[n + 1] == '"') {
      fields.back() += c;
      ++n;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

// Slicer 5 writes two more fields than "columns = id,x,y,z,..." declares: the point's status (2: defined) and
// another.
Result<GivenLandmarks> read_fcsv(const std::string& path, std::istream& file) {
  std::vector<std::string> columns =
      fields_of("id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID");
  double sign = -1;  // of x and y; -1: RAS, the default
  std::vector<Point> points;
  std::string line;
  for (int row = 1; std::getline(file, line); ++row) {
    const std::string where = fmt::format("{}:{}", path, row);
    if (trimmed(line).empty()) continue;
    if (line.starts_with('#')) {
      const auto equals = line.find('=');
      const std::string key = equals == std::string::npos ? "" : plain_name(line.substr(1, equals - 1));
      const std::string value(equals == std::string::npos ? "" : trimmed(line.substr(equals + 1)));
      if (key == "coordinatesystem") {
        if (value != "0" && value != "RAS" && value != "1" && value != "LPS")
          return failure(where,
                         "CoordinateSystem is \"" + printable(value) + "\"; expected LPS (1) or RAS (0)");
        sign = value == "1" || value == "LPS" ? 1 : -1;
      }
      if (key == "columns") columns = fields_of(value);
      continue;
    }
    const auto fields = fields_of(line);
    const auto field = [&](std::string_view name) -> std::string {
      const auto at = std::ranges::find(columns, name) - columns.begin();
      return at < std::ssize(fields) ? std::string(trimmed(fields[static_cast<std::size_t>(at)])) : "";
    };
    Point point{field("label"), {}, read_note(field("desc")), true};
    for (const auto& [axis, name] : {std::pair{0, "x"}, {1, "y"}, {2, "z"}}) {
      const std::string text = field(name);
      const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), point.place[axis]);
      if (wrong != std::errc() || end != text.data() + text.size() || !std::isfinite(point.place[axis]))
        return failure(where, fmt::format("{} is '{}'; expected a number in mm", name, printable(text)));
    }
    point.place.head<2>() *= sign;
    if (const auto extra = columns.size(); extra < fields.size() && !trimmed(fields[extra]).empty())
      point.set = trimmed(fields[extra]) == "2";
    points.push_back(std::move(point));
  }
  return as_landmarks(path, points);
}

Result<GivenLandmarks> read_own(const std::string& path) {
  auto read = read_landmarks(path);
  if (!read) return tl::unexpected(read.error());
  GivenLandmarks out;
  std::string strange;
  for (const auto& [name, landmark] : *read) {
    const std::string ours = landmark_of(name);
    if (ours.empty()) strange += (strange.empty() ? "" : ", ") + name;
    if (!ours.empty() && out.landmarks.contains(ours))
      return failure(path, "contains two points named " + ours);
    out.landmarks[ours.empty() ? name : ours] = landmark;
  }
  if (!strange.empty()) out.warnings.push_back(path + ": these names are not landmarks: " + strange);
  return out;
}

}  // namespace

Landmarks GivenLandmarks::all() const {
  Landmarks both = landmarks;
  both.insert(unmoved.begin(), unmoved.end());
  return both;
}

std::string landmark_of(std::string_view name) {
  const auto words = words_of(name);
  const auto is = [&](std::string whole) {
    if (words == words_of(whole)) return true;
    std::erase(whole, '_');  // written in one word: "hipleft"
    return words.size() == 1 && words.front() == whole;
  };
  for (const std::string_view one : landmark_names)
    if (is(std::string(one))) return std::string(one);
  for (const std::string_view stem : sided_landmark_names)
    for (const char* side : {"_left", "_right"})
      if (is(std::string(stem) + side)) return std::string(stem) + side;
  return "";
}

std::vector<std::string> doubts_of_given(const Landmarks& given, const Landmarks& found) {
  constexpr double far = 60;  // mm: more than found landmarks are off by within their deviation
  std::vector<std::string> doubts;
  for (const auto& [name, landmark] : given) {
    const auto own = found.find(name);
    if (own == found.end()) continue;
    const double off = (landmark.point - own->second.point).norm();
    if (off < far) continue;
    const bool left = name.ends_with("_left");
    std::string doubt = fmt::format("{} was placed {:.0f} mm from where the scan shows it", name, off);
    if (left || name.ends_with("_right")) {
      const std::string other = name.substr(0, name.rfind('_')) + (left ? "_right" : "_left");
      if (const auto it = found.find(other);
          it != found.end() && (landmark.point - it->second.point).norm() < 0.5 * off)
        doubt += fmt::format(", near {}; check whether left and right are confused (RAS for LPS)", other);
    }
    doubts.push_back(doubt);
  }
  return doubts;
}

void put_given(const Landmarks& given, Landmarks& landmarks) {
  for (const auto& [name, landmark] : given) {
    const auto found = landmarks.find(name);
    Landmark put = landmark;
    if (found != landmarks.end()) {
      if ((found->second.point - put.point).norm() < 0.01 && put.source == placed) continue;
      if (put.radius == 0) put.radius = found->second.radius;
    }
    if (put.radius == 0 && name.starts_with("shoulder")) put.radius = 24;
    landmarks[name] = put;
  }
}

Result<GivenLandmarks> read_given_landmarks(const std::string& path) {
  const std::string ending = lower_case(path);
  const auto text = read_input_file(path);
  if (!text) return tl::unexpected(text.error());
  std::istringstream file(*text);
  if (ending.ends_with(".fcsv")) return read_fcsv(path, file);
  if (ending.ends_with(".json")) {
    const auto document = parse_json(*text, path);
    if (!document) return tl::unexpected(document.error());
    if (document->is_object() && document->contains("markups") && (*document)["markups"].is_array())
      return read_markups(path, *document);
    if (ending.ends_with(".mrk.json"))
      return failure(path, "is not a point list of 3D Slicer: it contains no \"markups\"");
  }
  return read_own(path);
}

Result<void> write_markups(const std::string& path, const Landmarks& landmarks,
                           const std::vector<std::string>& given) {
  json points = json::array();
  for (const auto& [name, landmark] : landmarks) {
    std::string note = fmt::format("{}; deviation {:.6g} mm", landmark.source, landmark.deviation);
    if (landmark.radius > 0) note += fmt::format("; radius {:.6g} mm", landmark.radius);
    note += fmt::format("; {} at {:.3f} {:.3f} {:.3f}",
                        std::ranges::find(given, name) == given.end() ? "found" : "given", landmark.point[0],
                        landmark.point[1], landmark.point[2]);
    points.push_back({{"id", std::to_string(points.size() + 1)},
                      {"label", name},
                      {"description", note},
                      {"position", {landmark.point[0], landmark.point[1], landmark.point[2]}},
                      {"orientation", {-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0}},
                      {"selected", true},
                      {"locked", false},
                      {"visibility", true},
                      {"positionStatus", "defined"}});
  }
  const json document{
      {"@schema",
       "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
       "markups-schema-v1.0.3.json#"},
      {"markups", json::array({json{{"type", "Fiducial"},
                                    {"coordinateSystem", "LPS"},
                                    {"coordinateUnits", "mm"},
                                    {"locked", false},
                                    {"fixedNumberOfControlPoints", false},
                                    {"labelFormat", "%N-%d"},
                                    {"lastUsedControlPointNumber", points.size()},
                                    {"controlPoints", points}}})}};
  std::ofstream file(path, std::ios::binary);
  file << json_text(document, 1) << '\n';
  file.close();
  if (!file)
    return failure(path, "cannot be written; check the folder's permissions and the free disk space");
  return {};
}

}  // namespace borelli
