// Writes a motion as an MP4 video, drawn without a display and packed by ffmpeg (H.264).
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/video/film.hpp"

namespace borelli {

struct VideoOptions {
  int width = 1280, height = 720;  ///< pixels, even
  double rate = 25;                ///< frames a second of the video
  double speed = 1;                ///< seconds of motion in a second of the video
  double azimuth_deg = 40;         ///< of the camera about the vertical: 0 in front, 90 at the left
  double elevation_deg = 12;       ///< of the camera above the horizon
  FilmStyle style = FilmStyle::solid;
};

/// A force of the ground on the body over time.
struct ShownForce {
  std::vector<double> times;  ///< s, increasing
  std::vector<Eigen::Vector3d> force,
      point;  ///< of each time, N and p_W in m; not finite where there is none
};

/// What moves.
struct MovingBody {
  /// Each mesh has the name of the solid that carries it, and points in that solid's frame; a mesh whose name
  /// is no solid's stands still. Meshes named "world: ..." are the ground; without one a grid is drawn.
  std::vector<Mesh> meshes;
  std::vector<Colour> colours;
  const Skin* skin = nullptr;  ///< drawn instead of the meshes, except in the style wire
  const Trajectory* trajectory = nullptr;
  std::vector<ShownForce> forces;
  Eigen::Vector3d up{0, 0, 1};  ///< unit vector
  /// Where the body faces at the start; the views are named by it. None, or along `up`: against y, turned as
  /// z is to `up`.
  std::optional<Eigen::Vector3d> front = {};
};

/// Frames of a motion over `seconds`: from its start, `speed` / `rate` apart, up to its end.
std::size_t video_frames(double seconds, const VideoOptions& options);

/// Checks before the work: a size that the format allows, ffmpeg, a way to draw. Errors: in one sentence.
Result<void> check_video(const VideoOptions& options);

/// The film of a motion.
struct Film {
  FilmSet set;
  std::size_t frames = 0;
  FrameMaker frame;  ///< refers to the body
};
/// Positions between the trajectory's times are interpolated linearly, orientations along the shortest arc.
/// Errors: nothing to show, a trajectory without times.
Result<Film> film_of(const MovingBody& body, const VideoOptions& options);

/// Writes the video. `progress`: of the share done; false stops. Errors: those of film_of and check_video;
/// not writable; stopped.
Result<std::size_t> write_video(const std::filesystem::path& path, const MovingBody& body,
                                const VideoOptions& options,
                                const std::function<bool(double)>& progress = {});

}  // namespace borelli
