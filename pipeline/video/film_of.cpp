#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "dynamics/numbers/rotation_between.hpp"
#include "pipeline/export/decimate.hpp"
#include "pipeline/export/skin.hpp"
#include "pipeline/export/skin_pose.hpp"
#include "pipeline/video/video.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

/// Poses of the trajectory's solids at any time.
class Motion {
 public:
  explicit Motion(const Trajectory& trajectory) : of_(trajectory) {}

  double start() const { return of_.times.front(); }
  double span() const { return of_.times.back() - of_.times.front(); }

  std::vector<Pose> at(double t) const {
    const auto after = std::ranges::upper_bound(of_.times, t);
    const auto last = of_.times.size() - 1;
    const auto next = std::min(static_cast<std::size_t>(after - of_.times.begin()), last);
    const std::size_t before = next == 0 ? 0 : next - 1;
    const double step = of_.times[next] - of_.times[before];
    const double share = step > 0 ? std::clamp((t - of_.times[before]) / step, 0.0, 1.0) : 0;
    std::vector<Pose> poses;
    for (std::size_t s = 0; s < of_.solids.size(); ++s) {
      const Pose &a = of_.pose(before, s), &b = of_.pose(next, s);
      const Eigen::Quaterniond turn(a.R), to(b.R);
      poses.push_back({turn.slerp(share, to).toRotationMatrix(), (1 - share) * a.p + share * b.p});
    }
    return poses;
  }

  std::ptrdiff_t solid(const std::string& name) const {
    const auto found = std::ranges::find(of_.solids, name);
    return found == of_.solids.end() ? -1 : found - of_.solids.begin();
  }

 private:
  const Trajectory& of_;
};

/// What the frames need, shared by all of them.
struct Scenery {
  Motion motion;
  const MovingBody& body;
  VideoOptions options;
  bool skinned = false;
  std::vector<std::ptrdiff_t>
      solid_of;  // per mesh, the number of the solid that carries it; -1: none, it stands still
  double metres_per_newton = 0;
};

FilmArrow arrow_at(const ShownForce& force, double t, double metres_per_newton) {
  const auto after = std::ranges::upper_bound(force.times, t);
  const auto next = std::min(static_cast<std::size_t>(after - force.times.begin()), force.times.size() - 1);
  const std::size_t before = next == 0 ? 0 : next - 1;
  const bool first = next == 0 || t - force.times[before] < force.times[next] - t;
  const std::size_t n = first ? before : next;  // the nearest: contact begins and ends abruptly
  return {force.point[n], force.point[n] + metres_per_newton * force.force[n]};
}

FilmFrame frame_at(const Scenery& scenery, double t) {
  FilmFrame frame;
  const std::vector<Pose> X_WS = scenery.motion.at(t);
  for (const std::ptrdiff_t solid : scenery.solid_of)
    frame.X_WM.push_back(solid < 0 ? Pose{} : X_WS[static_cast<std::size_t>(solid)]);
  if (scenery.skinned) {
    ScanPoses poses;
    const auto& solids = scenery.body.trajectory->solids;
    for (std::size_t s = 0; s < solids.size(); ++s) poses.emplace(solids[s], X_WS[s]);
    frame.skin = deformed(*scenery.body.skin, poses);
  }
  for (const ShownForce& force : scenery.body.forces) {
    const FilmArrow arrow = arrow_at(force, t, scenery.metres_per_newton);
    if (arrow.to.allFinite() && (arrow.to - arrow.from).norm() > 0) frame.arrows.push_back(arrow);
  }
  frame.caption = fmt::format("{:.2f} s", t);
  if (scenery.options.speed != 1) frame.caption += fmt::format("   speed {:g}", scenery.options.speed);
  return frame;
}

/// The extent, along three directions, of all that moves.
struct FilmBounds {
  Eigen::Matrix3d axes;  // rows
  Vector3d least = Vector3d::Constant(1e300), greatest = -least;

  void add(const Vector3d& p) {
    const Vector3d x = axes * p;
    least = least.cwiseMin(x), greatest = greatest.cwiseMax(x);
  }
  Vector3d size() const { return greatest - least; }
  Vector3d middle() const { return (least + greatest) / 2; }
};

std::array<Vector3d, 8> corners_of(const Mesh& mesh) {
  Vector3d low = Vector3d::Constant(1e300), high = -low;
  for (const Eigen::Vector3f& p : mesh.points)
    low = low.cwiseMin(p.cast<double>()), high = high.cwiseMax(p.cast<double>());
  std::array<Vector3d, 8> corners;
  for (std::size_t n = 0; n < 8; ++n)
    corners[n] = {n & 1 ? high.x() : low.x(), n & 2 ? high.y() : low.y(), n & 4 ? high.z() : low.z()};
  return corners;
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `length`.
double round_up(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (const double m : {1, 2, 5})
    if (m * power >= length * (1 - 1e-9)) return m * power;
  return 10 * power;
}

/// The mesh for the wire style, with fewer triangles, within 0.4 % of the size: closer edges would merge in
/// the drawing.
Mesh sketched(const Mesh& mesh, double size) {
  if (mesh.triangles.size() < 500 || !is_closed(mesh)) return mesh;  // a shape of the scene
  TriangleSurface surface;
  for (const Eigen::Vector3f& p : mesh.points) surface.points.push_back(p.cast<double>());
  surface.triangles = mesh.triangles;
  surface = decimate(surface, 0.004 * size);
  Mesh out{mesh.name, {}, surface.triangles, mesh.label, mesh.density};
  for (const Vector3d& p : surface.points) out.points.push_back(p.cast<float>());
  return out;
}

FilmCamera camera_of(const VideoOptions& options, const Eigen::Matrix3d& upright) {
  const double a = options.azimuth_deg * std::numbers::pi / 180,
               e = options.elevation_deg * std::numbers::pi / 180;
  FilmCamera camera;
  camera.from = upright * Vector3d(std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e));
  camera.up = upright * Vector3d(-std::sin(a) * std::sin(e), std::cos(a) * std::sin(e), std::cos(e));
  return camera;
}

/// Turns z to `up` and -y to the body's front.
Eigen::Matrix3d upright_of(const MovingBody& body) {
  const Vector3d front = body.front.value_or(body.up), level = front - body.up.dot(front) * body.up;
  if (!(level.norm() > 0.3 * front.norm())) return rotation_between(Vector3d::UnitZ(), body.up);  // lies
  const Vector3d back = -level.normalized();
  Eigen::Matrix3d R;
  R << back.cross(body.up), back, body.up;
  return R;
}

bool is_ground(const Mesh& mesh) { return mesh.name.starts_with("world: "); }

/// Adds what moves in a frame, without arrows.
void add_body(const std::vector<Mesh>& meshes, const std::vector<std::array<Vector3d, 8>>& corners,
              const FilmFrame& frame, FilmBounds& bounds) {
  for (const Vector3d& p : frame.skin) bounds.add(p);
  if (frame.skin.empty())
    for (std::size_t m = 0; m < meshes.size(); ++m)
      if (!is_ground(meshes[m]))
        for (const Vector3d& corner : corners[m]) bounds.add(frame.X_WM[m] * corner);
}

double greatest_force(const std::vector<ShownForce>& forces) {
  double most = 0;
  for (const ShownForce& force : forces)
    for (std::size_t n = 0; n < force.force.size(); ++n)
      if (force.point[n].allFinite()) most = std::max(most, force.force[n].norm());
  return most;
}

/// Squares of about an eighth of the height, under all that moves.
FilmFloor floor_under(const FilmBounds& world, const Eigen::Matrix3d& upright) {
  const Vector3d size = world.size();
  FilmFloor floor;
  floor.square = round_up(size.maxCoeff() / 8);
  const auto squares = [&](double length) {
    return static_cast<int>(std::ceil((length + 0.4 * size.maxCoeff()) / floor.square));
  };
  floor.squares_across = squares(size.x()), floor.squares_along = squares(size.y());
  Vector3d middle = world.middle();
  middle.z() = world.least.z();
  floor.middle = upright * middle;
  floor.across = upright.col(0), floor.along = upright.col(1);
  return floor;
}

/// Sets camera, floor and the arrows' scale so that all frames fit.
void frame_all(Film& film, Scenery& scenery, const Eigen::Matrix3d& upright) {
  FilmSet& set = film.set;
  set.camera = camera_of(scenery.options, upright);
  std::vector<std::array<Vector3d, 8>> corners;
  for (const Mesh& mesh : set.meshes) corners.push_back(corners_of(mesh));
  Eigen::Matrix3d view;
  view << set.camera.right().transpose(), set.camera.up.transpose(), set.camera.from.transpose();
  FilmBounds seen{view}, world{upright.transpose()}, still{upright.transpose()};
  add_body(set.meshes, corners, film.frame(0), still);
  if (const double most = greatest_force(scenery.body.forces); most > 0)
    scenery.metres_per_newton = 0.4 * still.size().norm() / most;
  for (std::size_t n = 0; n < film.frames; ++n) {
    const FilmFrame frame = film.frame(n);
    add_body(set.meshes, corners, frame, seen);
    add_body(set.meshes, corners, frame, world);
    for (const FilmArrow& arrow : frame.arrows) seen.add(arrow.to);
  }
  if (std::ranges::none_of(set.meshes, is_ground)) set.floor = floor_under(world, upright);
  set.camera.middle = view.transpose() * seen.middle();
  const Vector3d size = seen.size();
  const double aspect = double(set.width) / set.height;
  set.camera.half_height = 0.56 * std::max({size.y(), size.x() / aspect, 1e-9});
}

}  // namespace

std::size_t video_frames(double seconds, const VideoOptions& options) {
  // a motion of 1.2 s has 31 frames at 25 Hz, although 1.2 * 25 may round to less than 30
  return static_cast<std::size_t>(std::floor(seconds * options.rate / options.speed + 1e-6)) + 1;
}

Result<Film> film_of(const MovingBody& body, const VideoOptions& options) {
  if (!body.trajectory || body.trajectory->times.empty())
    return failure("video", "needs a motion, but the trajectory has no rows");
  const bool skinned = body.skin != nullptr && options.style != FilmStyle::wire;
  if (!skinned && std::ranges::all_of(body.meshes, is_ground))
    return failure("video", "has nothing to show: no solid has a shape; give the solids shapes");
  auto scenery = std::make_shared<Scenery>(Scenery{Motion(*body.trajectory), body, options, skinned, {}, 0});
  Film film;
  film.set.width = options.width, film.set.height = options.height;
  film.set.style = options.style;
  film.frames = video_frames(scenery->motion.span(), options);
  if (skinned) {
    film.set.meshes = {body.skin->mesh};
    film.set.colours = {{0xd9, 0xb3, 0x9a}};
    scenery->solid_of = {-1};
  } else {
    FilmBounds size{Eigen::Matrix3d::Identity()};
    for (const Mesh& mesh : body.meshes)
      if (!is_ground(mesh))
        for (const Vector3d& corner : corners_of(mesh)) size.add(corner);
    for (std::size_t m = 0; m < body.meshes.size(); ++m) {
      const Mesh& mesh = body.meshes[m];
      film.set.meshes.push_back(options.style == FilmStyle::wire ? sketched(mesh, size.size().norm()) : mesh);
      film.set.colours.push_back(body.colours[m]);
      scenery->solid_of.push_back(scenery->motion.solid(mesh.name));
    }
  }
  film.frame = [scenery](std::size_t n) {
    const double late = static_cast<double>(n) * scenery->options.speed / scenery->options.rate;
    return frame_at(*scenery, scenery->motion.start() + std::min(late, scenery->motion.span()));
  };
  frame_all(film, *scenery, upright_of(body));
  return film;
}

}  // namespace borelli
