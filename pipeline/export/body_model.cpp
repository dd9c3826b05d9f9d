#include "pipeline/export/body_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "pipeline/motion/body_markers.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Landmarks of the trunk that marker sets do not have, and the ends of cut limbs.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> other_landmarks{
    {{"omphalion", "middle_trunk"},
     {"t12_l1", "middle_trunk"},
     {"l4_l5", "lower_trunk"},
     {"l5_s1", "lower_trunk"},
     {"forearm_end", "forearm"},
     {"shank_end", "shank"},
     {"mid_hip", "lower_trunk"}}};

// To each landmark the landmark or the part that body_markers() is to place it by.
JointMapping places_of(const Landmarks& landmarks) {
  JointMapping out;
  const std::vector<std::string> known = marker_places();
  for (const auto& [name, landmark] : landmarks) {
    std::string place;
    if (std::ranges::find(known, name) != known.end()) place = name;
    for (const Part& part : parts)
      if (part.joint == name && !part.joint.empty()) place = part.name;
    for (const auto& [stem, part] : other_landmarks)
      for (const std::string_view side : {"", "_left", "_right"})
        if (name == std::string(stem) + std::string(side)) place = std::string(part) + std::string(side);
    if (!place.empty()) out.entries.push_back({name, place});
  }
  return out;
}

const EntryDeviation* deviation_of(const InertiaRow& row, std::string_view entry) {
  const auto found = std::ranges::find(row.deviations, entry, &EntryDeviation::entry);
  return found == row.deviations.end() ? nullptr : &*found;
}

// "0.1 0.2 0.3": the deviations of these entries; empty if one is not known.
std::string deviations_of(const InertiaRow& row, std::initializer_list<std::string_view> entries) {
  std::string out;
  for (const std::string_view entry : entries) {
    const EntryDeviation* one = deviation_of(row, entry);
    if (!one) return "";
    out += fmt::format("{}{:.3g}", out.empty() ? "" : " ", one->total);
  }
  return out;
}

void add_source(const InertiaSource& source, std::vector<std::string>& lines) {
  std::string line = "Made by borelli " BORELLI_VERSION;
  if (!source.volume.empty()) line += " from " + source.volume;
  lines.push_back(line);
  for (const auto& [what, text] : {std::pair{"density curve", &source.density_curve},
                                   {"cuts between parts", &source.cuts},
                                   {"axes of the parts", &source.frames},
                                   {"pose in the scan", &source.pose},
                                   {"segmentation", &source.segmentation}})
    if (!text->empty()) lines.push_back(fmt::format("{}: {}", what, *text));
}

void add_deviations(const InertiaTable& table, std::vector<std::string>& lines) {
  for (const InertiaRow& row : table.rows) {
    const std::string mass = deviations_of(row, {"mass_kg"}),
                      centre = deviations_of(row, {"centre_x_m", "centre_y_m", "centre_z_m"}),
                      tensor =
                          deviations_of(row, {"patient_Ixx_kgm2", "patient_Iyy_kgm2", "patient_Izz_kgm2",
                                              "patient_Ixy_kgm2", "patient_Ixz_kgm2", "patient_Iyz_kgm2"});
    std::string line;
    if (!mass.empty()) line += fmt::format(" mass {} kg", mass);
    if (!centre.empty()) line += fmt::format("{} mass centre {} m", line.empty() ? "" : ",", centre);
    if (!tensor.empty())
      line += fmt::format("{} inertia xx yy zz xy xz yz {} kg m^2", line.empty() ? "" : ",", tensor);
    if (!line.empty()) lines.push_back(fmt::format("standard deviations of {}:{}", row.part, line));
  }
}

void add_joints(const PartInertials& present, const Landmarks& landmarks, std::vector<std::string>& lines) {
  for (const Part& part : parts) {
    const auto joint = landmarks.find(part.joint);
    if (joint == landmarks.end() || !present.contains(part.name)) continue;
    lines.push_back(fmt::format("joint centre {}: standard deviation {:.3g} mm along each axis ({})",
                                joint->first, joint->second.deviation, joint->second.source));
  }
}

}  // namespace

Scene with_landmark_markers(Scene scene, const PartInertials& present, const Landmarks& landmarks) {
  const auto X_WS = scan_poses(present, landmarks);
  std::set<std::string> taken;
  for (const Marker& marker : scene.markers) taken.insert(marker.name);
  std::vector<std::string> names, segments;
  for (const auto& [name, landmark] : landmarks) names.push_back(name);
  for (const Solid& solid : scene.solids)
    if (X_WS.contains(solid.name)) segments.push_back(solid.name);
  for (const BodyMarker& one :
       body_markers(names, landmarks, segments, PointKind::markers, places_of(landmarks)).markers) {
    if (!taken.insert(one.name).second) continue;
    const Vector3d place = 1e-3 * landmarks.find(one.name)->second.point;
    scene.markers.push_back({one.name, {one.segment, X_WS.find(one.segment)->second.inverse() * place}});
  }
  return scene;
}

ModelExtras body_extras(const InertiaTable& table, const PartInertials& present, const Landmarks& landmarks,
                        const std::vector<std::filesystem::path>& mesh_files) {
  ModelExtras out;
  add_source(table.source, out.comments);
  add_deviations(table, out.comments);
  add_joints(present, landmarks, out.comments);
  const auto X_WS = scan_poses(present, landmarks);
  for (const std::filesystem::path& file : mesh_files) {
    const auto found = X_WS.find(file.stem().string());
    if (found != X_WS.end()) out.meshes.push_back({found->first, file.generic_string(), 1, -found->second.p});
  }
  for (const InertiaRow& row : table.rows) {
    const auto found = X_WS.find(row.part);
    if (found == X_WS.end() || !row.frame) continue;
    const Vector3d origin = row.frame->origin_name.empty() ? found->second.p : row.frame->origin;
    out.frames.push_back(
        {row.part, row.part + "_anatomical", found->second.inverse() * Pose{row.frame->R_WA, origin}});
  }
  return out;
}

}  // namespace borelli
