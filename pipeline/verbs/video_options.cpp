#include "pipeline/verbs/video_options.hpp"

#include <array>
#include <cstdio>

#include "error/file_ending.hpp"
#include "pipeline/report/scene_meshes.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

struct NamedView {
  const char* name;
  double azimuth_deg, elevation_deg;
};
constexpr std::array views{NamedView{"oblique", 40, 12}, NamedView{"front", 0, 5},
                           NamedView{"left", 90, 5},     NamedView{"right", -90, 5},
                           NamedView{"back", 180, 5},    NamedView{"above", 0, 90}};

}  // namespace

void add_video_options(CLI::App& verb, VideoAsked& asked, const std::string& where) {
  // (the other options do not require --video here, since a run's stored settings contain all of them;
  // check_effect refuses values that differ from the defaults)
  verb.add_option("--video", asked.file,
                  "Also write a video of the motion, .mp4; " + where + "; needs ffmpeg")
      ->type_name("FILE");
  std::vector<std::string> names;
  for (const NamedView& view : views) names.emplace_back(view.name);
  verb.add_option("--video-size", asked.size, "Width and height, pixels, both even")
      ->type_name("WIDTHxHEIGHT")
      ->capture_default_str();
  verb.add_option("--video-rate", asked.rate, "Frames per second")
      ->check(number_within(1.0, 240.0))
      ->capture_default_str();
  verb.add_option("--video-speed", asked.speed, "Seconds of motion in a second of video; 0.25: slow motion")
      ->check(number_within(1e-6, 1e6))
      ->capture_default_str();
  verb.add_option("--video-view", asked.view, "Where the camera is, as the body faces at the start")
      ->check(one_of(names))
      ->capture_default_str();
  verb.add_option("--video-style", asked.style, "Lit surfaces, or black edges on white without hidden ones")
      ->check(one_of({"solid", "wire"}))
      ->capture_default_str();
  group_options(
      verb, "Video",
      {"--video", "--video-size", "--video-rate", "--video-speed", "--video-view", "--video-style"});
}

Result<void> check_effect(const VideoAsked& asked) {
  if (!asked.file.empty()) return {};
  const VideoAsked unset;
  for (const auto& [option, is_set] : {std::pair("--video-size", asked.size != unset.size),
                                       std::pair("--video-rate", asked.rate != unset.rate),
                                       std::pair("--video-speed", asked.speed != unset.speed),
                                       std::pair("--video-view", asked.view != unset.view),
                                       std::pair("--video-style", asked.style != unset.style)})
    if (is_set) return bad_use(option, "has no effect without --video, which names the file to write");
  return {};
}

Result<VideoOptions> video_options(const VideoAsked& asked) {
  if (ending_of(asked.file) != ".mp4")
    return bad_use("--video " + asked.file, "is not a video file; end the name in .mp4");
  VideoOptions options;
  int read = 0;
  if (std::sscanf(asked.size.c_str(), "%5dx%5d%n", &options.width, &options.height, &read) != 2 ||
      static_cast<std::size_t>(read) != asked.size.size())
    return bad_use("--video-size " + asked.size, "is not a size in pixels; write it as 1280x720");
  options.rate = asked.rate, options.speed = asked.speed;
  options.style = asked.style == "wire" ? FilmStyle::wire : FilmStyle::solid;
  for (const NamedView& view : views)
    if (asked.view == view.name)
      options.azimuth_deg = view.azimuth_deg, options.elevation_deg = view.elevation_deg;
  if (auto fine = check_video(options); !fine) return tl::unexpected(fine.error());
  return options;
}

Result<std::size_t> write_scene_video(const VideoAsked& asked, const Scene& scene,
                                      const Trajectory& trajectory,
                                      const std::function<bool(double)>& progress) {
  const auto options = video_options(asked);
  if (!options) return tl::unexpected(options.error());
  auto meshes = scene_meshes(scene);
  if (!meshes) return tl::unexpected(meshes.error());
  MovingBody body;
  for (const Mesh& mesh : *meshes) {
    const auto solid = std::ranges::find(scene.solids, mesh.name, &Solid::name);
    body.colours.push_back(solid == scene.solids.end()
                               ? Colour{0xd8, 0xd8, 0xd8}
                               : other_colour(static_cast<std::size_t>(solid - scene.solids.begin()) + 1));
  }
  body.meshes = std::move(*meshes);
  body.trajectory = &trajectory;
  if (scene.gravity.norm() > 0) body.up = -scene.gravity.normalized();
  return write_video(asked.file, body, *options, progress);
}

}  // namespace borelli
