#include "pipeline/stages/run_video.hpp"

#include <optional>

#include "error/json_text.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/export/skin.hpp"
#include "pipeline/video/video.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

using nlohmann::json;

Eigen::Vector3d vector_of(const json& numbers) {
  if (!numbers.is_array() || numbers.size() != 3) return Eigen::Vector3d::Constant(std::nan(""));
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

/// The ground forces of motion/efforts.json (effort_report.hpp).
Result<std::vector<ShownForce>> ground_forces(const RunData& data) {
  std::vector<ShownForce> forces;
  if (data.settings.captured.motion.empty()) return forces;
  const std::filesystem::path path = data.file("motion/efforts.json");
  const auto bytes = read_input_file(path, any_size);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto efforts = parse_json(*bytes, path.string());
  if (!efforts) return tl::unexpected(efforts.error());
  try {
    for (const json& from : efforts->at("forces")) {
      ShownForce force;
      force.times = efforts->at("times").get<std::vector<double>>();
      for (const json& f : from.at("force")) force.force.push_back(vector_of(f));
      for (const json& p : from.at("point")) force.point.push_back(vector_of(p));
      if (force.times.empty() || force.force.size() != force.times.size() ||
          force.point.size() != force.times.size())
        throw json::other_error::create(500, "lengths differ", nullptr);
      forces.push_back(std::move(force));
    }
  } catch (const json::exception&) {
    return failure(path.string(), "is damaged; remove it, and the next run writes it again");
  }
  return forces;
}

Result<ScanPoses> poses_of_run(RunData& data) {
  const auto table = data.table();
  if (!table) return tl::unexpected(table.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  std::vector<Warning> said_by_the_scene;
  return scan_poses(movable_parts(**table, said_by_the_scene), (*segmentation)->landmarks);
}

}  // namespace

Result<Skin> skin_of_run(RunData& data) {
  const auto labels = data.labels();
  if (!labels) return tl::unexpected(labels.error());
  const auto X_WS = poses_of_run(data);
  if (!X_WS) return tl::unexpected(X_WS.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  SkinOptions options;
  options.tolerance = 1e-3 * data.settings.mesh_tolerance_mm;
  options.threads = data.settings.threads;
  return skin_of(**labels, skin_joints(**labels, (*segmentation)->landmarks), *X_WS, options);
}

Result<json> make_video(RunData& data, const StageProgress& progress) {
  const auto meshes = data.meshes();
  if (!meshes) return tl::unexpected(meshes.error());
  const auto trajectory = data.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto X_WS = poses_of_run(data);
  if (!X_WS) return tl::unexpected(X_WS.error());
  auto forces = ground_forces(data);
  if (!forces) return tl::unexpected(forces.error());
  MovingBody body;
  for (Mesh mesh : **meshes) {
    body.colours.push_back(part_colour(mesh.name));
    if (const auto rest = X_WS->find(mesh.name); rest != X_WS->end())
      for (Eigen::Vector3f& p : mesh.points) p = (rest->second.inverse() * p.cast<double>()).cast<float>();
    body.meshes.push_back(std::move(mesh));
  }
  body.trajectory = *trajectory;
  body.forces = std::move(*forces);
  std::optional<Skin> skin;
  if (data.settings.skin && data.settings.video_options.style != FilmStyle::wire) {
    auto made = skin_of_run(data);
    if (!made) return tl::unexpected(made.error());
    body.skin = &skin.emplace(std::move(*made));
  }
  const auto frames =
      write_video(data.file(data.settings.video), body, data.settings.video_options, progress);
  if (!frames) return tl::unexpected(frames.error());
  return json{{"frames", *frames}};
}

}  // namespace borelli
