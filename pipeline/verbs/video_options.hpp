// The options of verbs that write a video, and the video of a scene's motion.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "dynamics/scene/scene.hpp"
#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/video/video.hpp"

namespace borelli {

struct VideoAsked {
  std::string file;  ///< .mp4; empty: none
  std::string size = "1280x720", view = "oblique", style = "solid";
  double rate = 25, speed = 1;
};

/// Adds --video, --video-size, --video-rate, --video-speed, --video-view and --video-style.
/// `where`: of the file, for the help.
void add_video_options(CLI::App& verb, VideoAsked& asked, const std::string& where);

/// Refuses settings of a video where no video is asked for: they would have no effect.
Result<void> check_effect(const VideoAsked& asked);

/// Errors: a name that does not end in .mp4; a size that is none; those of check_video.
Result<VideoOptions> video_options(const VideoAsked& asked);

/// Writes the video of a scene's motion: its solids' shapes (scene_meshes), gravity downwards.
Result<std::size_t> write_scene_video(const VideoAsked& asked, const Scene& scene,
                                      const Trajectory& trajectory,
                                      const std::function<bool(double)>& progress);

}  // namespace borelli
