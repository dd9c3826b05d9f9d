#include "segmentation/files/landmarks_file.hpp"

#include <cmath>
#include <fstream>

#include "error/json_text.hpp"
#include "process/input_file.hpp"

namespace borelli {

using nlohmann::json;

Result<void> write_landmarks(const std::string& path, const Landmarks& landmarks) {
  json all = json::object();
  for (const auto& [name, landmark] : landmarks)
    all[name] = {{"point", {landmark.point[0], landmark.point[1], landmark.point[2]}},
                 {"deviation", landmark.deviation},
                 {"radius", landmark.radius},
                 {"source", landmark.source}};
  std::ofstream file(path, std::ios::binary);
  file << json_text(json{{"frame", "LPS"}, {"unit", "mm"}, {"landmarks", all}}, 1) << '\n';
  file.close();
  if (!file)
    return failure(path, "cannot be written; check the folder's permissions and the free disk space");
  return {};
}

Result<Landmarks> read_landmarks(const std::string& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto parsed = parse_json(*bytes, path);
  if (!parsed) return tl::unexpected(parsed.error());
  const json& document = *parsed;
  if (!document.is_object() || !document.contains("landmarks") || !document["landmarks"].is_object())
    return failure(
        path,
        "contains no \"landmarks\"; expected {\"frame\": \"LPS\", \"unit\": \"mm\", \"landmarks\": {...}}");
  const auto text = [](const json& object, const char* key, const char* otherwise) {
    return object.contains(key) && object[key].is_string() ? object[key].get<std::string>()
                                                           : std::string(otherwise);
  };
  const std::string frame = text(document, "frame", "LPS"), unit = text(document, "unit", "mm");
  if (frame != "LPS" && frame != "RAS")
    return failure(path, "frame is \"" + frame + "\"; expected LPS or RAS");
  if (unit != "mm") return failure(path, "unit is \"" + unit + "\"; expected mm");

  Landmarks landmarks;
  for (const auto& [name, entry] : document["landmarks"].items()) {
    Landmark landmark;
    const auto bad =
        failure(path, "landmark " + name + ": expected \"point\": [x, y, z], three finite numbers in mm");
    if (!entry.is_object() || !entry.contains("point") || !entry["point"].is_array() ||
        entry["point"].size() != 3)
      return bad;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!entry["point"][c].is_number()) return bad;
      landmark.point[static_cast<Eigen::Index>(c)] = entry["point"][c].get<double>();
    }
    if (!landmark.point.allFinite()) return bad;
    if (frame == "RAS") landmark.point.head<2>() *= -1;
    for (const auto& [key, value] :
         {std::pair{"deviation", &landmark.deviation}, {"radius", &landmark.radius}})
      if (entry.contains(key)) {
        if (!entry[key].is_number() || entry[key].get<double>() < 0)
          return failure(path, "landmark " + name + ": " + key + " must be a number, 0 or more");
        *value = entry[key].get<double>();
      }
    landmark.source = text(entry, "source", "given");
    landmarks[name] = landmark;
  }
  return landmarks;
}

}  // namespace borelli
