#include "pipeline/stages/run_video.hpp"

#include "error/json_text.hpp"
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

/// Where the body faces at the start: a scan's front is -y of the patient frame (x left, y back, z up), and
/// the first solid that the scan has carries it.
std::optional<Eigen::Vector3d> facing(const Trajectory& trajectory, const ScanPoses& X_WS) {
  for (std::size_t s = 0; s < trajectory.solids.size(); ++s)
    if (const auto rest = X_WS.find(trajectory.solids[s]); rest != X_WS.end())
      return trajectory.pose(0, s).R * rest->second.R.transpose() * Eigen::Vector3d(0, -1, 0);
  return std::nullopt;
}

}  // namespace

Result<json> make_video(RunData& data, const StageProgress& progress) {
  const auto meshes = data.meshes();
  if (!meshes) return tl::unexpected(meshes.error());
  const auto trajectory = data.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto X_WS = data.poses();
  if (!X_WS) return tl::unexpected(X_WS.error());
  auto forces = ground_forces(data);
  if (!forces) return tl::unexpected(forces.error());
  MovingBody body;
  for (Mesh mesh : **meshes) {
    body.colours.push_back(part_colour(mesh.name));
    if (const auto rest = (*X_WS)->find(mesh.name); rest != (*X_WS)->end())
      for (Eigen::Vector3f& p : mesh.points) p = (rest->second.inverse() * p.cast<double>()).cast<float>();
    body.meshes.push_back(std::move(mesh));
  }
  body.trajectory = *trajectory;
  if (!(*trajectory)->times.empty()) body.front = facing(**trajectory, **X_WS);
  body.forces = std::move(*forces);
  if (data.settings.skin && data.settings.video_options.style != FilmStyle::wire) {
    const auto skin = data.skin();
    if (!skin) return tl::unexpected(skin.error());
    body.skin = *skin;
  }
  const auto frames =
      write_video(data.file(data.settings.video), body, data.settings.video_options, progress);
  if (!frames) return tl::unexpected(frames.error());
  return json{{"frames", *frames}};
}

}  // namespace borelli
