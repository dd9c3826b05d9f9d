// What a film shows: a scenery that stays, and what moves in each frame. on_demand/vtk draws it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dynamics/numbers/pose.hpp"
#include "error/error.hpp"
#include "pipeline/export/mesh.hpp"
#include "pipeline/files/palette.hpp"

namespace borelli {

enum class FilmStyle {
  solid,  ///< lit surfaces in colours
  wire    ///< black edges on white, hidden ones removed (the paper's figure 9)
};

/// A camera in parallel projection: a point p is at pixel (width / 2 + s right.(p - middle),
/// height / 2 - s up.(p - middle)) from the upper left corner, with s = height / (2 half_height).
struct FilmCamera {
  Eigen::Vector3d middle{0, 0, 0};  ///< p_W at the picture's centre, m
  Eigen::Vector3d from{0, -1, 0};   ///< unit vector from there to the camera
  Eigen::Vector3d up{0, 0, 1};      ///< unit, normal to `from`
  double half_height = 1;           ///< m

  Eigen::Vector3d right() const { return up.cross(from); }
};

/// A grid of squares on the floor.
struct FilmFloor {
  Eigen::Vector3d middle{0, 0, 0}, across{1, 0, 0}, along{0, 1, 0};  ///< p_W, m; unit vectors
  double square = 0.25;                                              ///< m
  int squares_across = 8, squares_along = 8;
};

struct FilmSet {
  std::vector<Mesh> meshes;  ///< points in each mesh's own frame M, m
  std::vector<Colour> colours;
  int width = 1280, height = 720;  ///< pixels
  FilmStyle style = FilmStyle::solid;
  FilmCamera camera;
  std::optional<FilmFloor> floor;
};

struct FilmArrow {
  Eigen::Vector3d from, to;  ///< p_W, m
};

struct FilmFrame {
  std::vector<Pose> X_WM;             ///< of each mesh
  std::vector<Eigen::Vector3d> skin;  ///< p_W of the first mesh's points, m; empty: it moves by its pose
  std::vector<FilmArrow> arrows;
  std::string caption;
};

/// Called once a frame, in order.
using FrameMaker = std::function<FilmFrame(std::size_t)>;
/// Takes a frame's pixels: height rows of width RGB triples, the lowest row first.
using FrameTaker = std::function<Result<void>(std::span<const std::uint8_t>)>;

}  // namespace borelli
