// Videos: positions in their frames, from pixels and an independent projection; properties of the file by
// ffprobe.
#include "pipeline/video/video.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "pipeline/export/skin.hpp"
#include "pipeline/on_demand/vtk.hpp"
#include "process/on_demand.hpp"

namespace borelli::test::video_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Pixels = std::vector<std::uint8_t>;

/// A closed box about its own origin.
Mesh box(const std::string& name, const Vector3d& size) {
  Mesh mesh;
  mesh.name = name;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3f p;
    for (int c = 0; c < 3; ++c) p[c] = static_cast<float>((corner >> c & 1 ? 0.5 : -0.5) * size[c]);
    mesh.points.push_back(p);
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Vector3d thrown(double t) { return {0.3 - 1.2 * t, 0.5 * t, 1 + 2 * t - 4.9 * t * t}; }
Eigen::Matrix3d tumbled(double t) {
  return Eigen::AngleAxisd(3 * t, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
}

/// A red box that flies and tumbles for 0.5 s, stored 200 times a second.
Trajectory flight() {
  Trajectory trajectory;
  trajectory.solids = {"box"};
  for (int n = 0; n <= 100; ++n) {
    const double t = 0.005 * n;
    trajectory.times.push_back(2 + t);
    trajectory.poses.push_back({tumbled(t), thrown(t)});
  }
  return trajectory;
}

MovingBody flying_box(const Trajectory& trajectory) {
  MovingBody body;
  body.meshes = {box("box", {0.3, 0.2, 0.1})};
  body.colours = {{230, 20, 20}};
  body.trajectory = &trajectory;
  return body;
}

std::vector<Pixels> frames_of(const Film& film) {
  const auto vtk = on_demand<VtkFunctions>();
  EXPECT_TRUE(vtk) << vtk.error().message();
  std::vector<Pixels> frames;
  const auto drawn =
      (*vtk)->draw_film(film.set, film.frames, film.frame, [&](std::span<const std::uint8_t> p) {
        frames.emplace_back(p.begin(), p.end());
        return Result<void>{};
      });
  EXPECT_TRUE(drawn) << drawn.error().message();
  return frames;
}

/// Mean position of red pixels, from the upper left corner. Rows of `pixels` run upwards.
Vector2d red_centroid(const Pixels& pixels, int width, int height, int least = 200) {
  Vector2d sum(0, 0);
  double count = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* p = &pixels[3 * (std::size_t(y) * std::size_t(width) + std::size_t(x))];
      if (p[0] < p[2] + 40) continue;
      sum += Vector2d(x + 0.5, height - y - 0.5);
      ++count;
    }
  EXPECT_GT(count, least);
  return sum / count;
}

/// Projection of p for a camera at these angles about the vertical, by turning the world in front of it.
Vector2d projected(const Vector3d& p, const VideoOptions& o, const FilmCamera& camera) {
  const double degree = std::numbers::pi / 180;
  const Vector3d q = Eigen::AngleAxisd(o.elevation_deg * degree, Vector3d::UnitX()) *
                     (Eigen::AngleAxisd(-o.azimuth_deg * degree, Vector3d::UnitZ()) * (p - camera.middle));
  const double scale = o.height / (2 * camera.half_height);
  return {o.width / 2.0 + scale * q.x(), o.height / 2.0 - scale * q.z()};
}

// A box is symmetric about its centre, so its silhouette's centroid is the centre's projection.
TEST(Film, ShowsTheGravityCentreWhereItIs) {
  const Trajectory trajectory = flight();
  for (const double azimuth : {0.0, 90.0, -130.0})
    for (const double speed : {1.0, 0.4}) {
      VideoOptions options{.width = 640, .height = 360, .rate = 10, .speed = speed};
      options.azimuth_deg = azimuth, options.elevation_deg = 20;
      const MovingBody body = flying_box(trajectory);
      const auto film = film_of(body, options);
      ASSERT_TRUE(film) << film.error().message();
      ASSERT_EQ(film->frames, speed == 1 ? 6u : 13u);
      const auto frames = frames_of(*film);
      ASSERT_EQ(frames.size(), film->frames);
      for (const std::size_t n : {std::size_t{0}, frames.size() / 2, frames.size() - 1}) {
        const double t = double(n) * speed / options.rate;
        const Vector2d seen = red_centroid(frames[n], options.width, options.height);
        EXPECT_LT((seen - projected(thrown(t), options, film->set.camera)).norm(), 0.5)  // of a pixel
            << azimuth << " " << t << ": " << seen.transpose();
      }
    }
}

// With gravity along -y, up is y, and the camera looks from +z.
TEST(Film, TurnsWithTheVertical) {
  const Trajectory trajectory = flight();
  Trajectory turned = trajectory;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3d::UnitX()).toRotationMatrix();
  for (Pose& X : turned.poses) X = {R * X.R, R * X.p};
  const VideoOptions options{.width = 320, .height = 180, .rate = 4};
  const MovingBody body = flying_box(trajectory);
  MovingBody other = flying_box(turned);
  other.up = {0, 1, 0};
  const auto film = film_of(body, options), again = film_of(other, options);
  ASSERT_TRUE(film && again);
  const auto frames = frames_of(*film), same = frames_of(*again);
  for (std::size_t n = 0; n < frames.size(); ++n)
    EXPECT_LT((red_centroid(frames[n], 320, 180) - red_centroid(same[n], 320, 180)).norm(), 0.1) << n;
}

// A body that faces x has its left along y. A lying body's views have no side names.
TEST(Film, NamesViewsByWhereTheBodyFaces) {
  const Trajectory trajectory = flight();
  MovingBody body = flying_box(trajectory);
  const auto camera_at = [&](double azimuth) {
    VideoOptions options;
    options.azimuth_deg = azimuth, options.elevation_deg = 0;
    return film_of(body, options).value().set.camera;
  };
  body.front = Vector3d(2, 0, 0.3);
  EXPECT_LT((camera_at(0).from - Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((camera_at(90).from - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((camera_at(90).up - Vector3d(0, 0, 1)).norm(), 1e-12);
  body.front = Vector3d(0, 0, 1);
  EXPECT_LT((camera_at(0).from - Vector3d(0, -1, 0)).norm(), 1e-12);
}

TEST(Film, DrawsForcesWhereTheyAct) {
  const Trajectory trajectory = flight();
  MovingBody body = flying_box(trajectory);
  body.colours = {{90, 90, 90}};  // only the arrow is red
  ShownForce force;
  force.times = trajectory.times;
  for (std::size_t n = 0; n < force.times.size(); ++n) {
    const bool there = force.times[n] < 2.22;
    force.force.push_back(there ? Vector3d(0, 0, 500) : Vector3d::Zero());
    force.point.push_back(there ? Vector3d(0.6, 0, 0.4) : Vector3d::Constant(std::nan("")));
  }
  body.forces = {force};
  VideoOptions options{.width = 640, .height = 360, .rate = 10};
  options.azimuth_deg = 0, options.elevation_deg = 0;
  const auto film = film_of(body, options);
  ASSERT_TRUE(film);
  const auto frames = frames_of(*film);
  const Vector2d foot = projected({0.6, 0, 0.4}, options, film->set.camera);
  const Vector2d seen = red_centroid(frames[1], 640, 360, 20);
  EXPECT_NEAR(seen.x(), foot.x(), 0.5);  // the arrow is upright
  EXPECT_LT(seen.y(), foot.y() - 10);
  int red = 0;
  for (std::size_t p = 0; p < frames[4].size(); p += 3) red += frames[4][p] >= frames[4][p + 2] + 40;
  EXPECT_EQ(red, 0);  // after contact
}

TEST(Film, RemovesHiddenLines) {
  Trajectory still;
  still.solids = {"front", "behind"};
  still.times = {0};
  still.poses = {{Eigen::Matrix3d::Identity(), {0, -1, 0}}, {Eigen::Matrix3d::Identity(), {0.2, 1, 0.1}}};
  MovingBody body;
  body.meshes = {box("front", {1, 0.2, 1}), box("behind", {1, 0.2, 1})};
  body.colours.resize(2);
  body.trajectory = &still;
  VideoOptions options{.width = 400, .height = 400, .style = FilmStyle::wire};
  options.azimuth_deg = 0, options.elevation_deg = 0;
  auto film = film_of(body, options);
  ASSERT_TRUE(film);
  film->set.floor.reset();
  const auto frames = frames_of(*film);
  const auto darkest_near = [&](const Vector3d& p) {
    const Vector2d at = projected(p, options, film->set.camera);
    int least = 255;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        const int x = static_cast<int>(at.x()) + dx, y = 399 - static_cast<int>(at.y()) + dy;
        least = std::min<int>(least, frames[0][3 * std::size_t(y * 400 + x)]);
      }
    return least;
  };
  EXPECT_LT(darkest_near({0.5, -1, 0}), 160);       // the front's right edge
  EXPECT_LT(darkest_near({0.7, 1, 0.3}), 160);      // the right edge behind, beside the front
  EXPECT_GT(darkest_near({-0.3, 1, -0.1}), 250);    // its left edge is hidden
  EXPECT_GT(darkest_near({-0.2, -1, -0.25}), 250);  // no diagonals of flat faces
}

TEST(Film, BendsASkin) {
  Skin skin;
  skin.mesh = box("skin", {0.3, 0.2, 0.1});
  skin.parts = {{.name = "box"}};
  skin.bones = {{"box", 0}};
  skin.bones_of.assign(8, {0, 0, 0, 0});
  skin.weights.assign(8, {1, 0, 0, 0});
  const Trajectory trajectory = flight();
  MovingBody body = flying_box(trajectory);
  body.skin = &skin;
  VideoOptions options{.width = 640, .height = 360, .rate = 10};
  const auto film = film_of(body, options);
  ASSERT_TRUE(film);
  const auto frames = frames_of(*film);
  // skin is pale: count pixels redder than the grey-blue background
  for (const std::size_t n : {0u, 3u, 5u}) {
    Vector2d sum(0, 0);
    double count = 0;
    for (std::size_t p = 0; p < frames[n].size(); p += 3)
      if (frames[n][p] > frames[n][p + 2] + 15) {
        const std::size_t pixel = p / 3;
        sum += Vector2d(double(pixel % 640) + 0.5, 360 - double(pixel / 640) - 0.5), ++count;
      }
    ASSERT_GT(count, 200);
    EXPECT_LT((sum / count - projected(thrown(0.1 * double(n)), options, film->set.camera)).norm(), 0.7) << n;
  }
}

class VideoFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "borelli-video-XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  /// What ffprobe says about the file's picture.
  std::string probed(const std::string& entries) const {
    const std::string command =
        "ffprobe -v error -count_frames -select_streams v:0 -show_entries stream=" + entries +
        " -of csv=p=0 '" + (folder_ / "a.mp4").string() + "'";
    std::string text;
    FILE* const answer = popen(command.c_str(), "r");
    if (!answer) return text;
    std::array<char, 512> line{};
    while (std::fgets(line.data(), line.size(), answer)) text += line.data();
    pclose(answer);
    return text;
  }
  fs::path folder_;
};

TEST_F(VideoFile, HasTheRequestedSizeRateAndLength) {
  const Trajectory trajectory = flight();
  const MovingBody body = flying_box(trajectory);
  const VideoOptions options{.width = 322, .height = 180, .rate = 30, .speed = 0.5};
  double share = 0;
  const auto frames = write_video(folder_ / "a.mp4", body, options, [&](double done) {
    EXPECT_GT(done, share);
    share = done;
    return true;
  });
  ASSERT_TRUE(frames) << frames.error().message();
  EXPECT_EQ(*frames, 31u);  // 0.5 s at half the speed, 30 frames a second, and the end
  EXPECT_EQ(share, 1);
  EXPECT_EQ(probed("codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames"),
            "h264,322,180,yuv420p,30/1,31\n");
  EXPECT_NEAR(std::atof(probed("duration").c_str()), 31 / 30.0, 0.002);
}

TEST_F(VideoFile, IsNotWrittenIfStopped) {
  const Trajectory trajectory = flight();
  const MovingBody body = flying_box(trajectory);
  const auto stopped = write_video(folder_ / "a.mp4", body, {.width = 320, .height = 180},
                                   [](double done) { return done < 0.5; });
  ASSERT_FALSE(stopped);
  EXPECT_NE(stopped.error().message().find("was stopped"), std::string::npos) << stopped.error().message();
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(VideoFile, NeedsFfmpegAndASizeOfItsFormat) {
  const Trajectory trajectory = flight();
  const MovingBody body = flying_box(trajectory);
  const auto odd = write_video(folder_ / "a.mp4", body, {.width = 321, .height = 180});
  ASSERT_FALSE(odd);
  EXPECT_NE(odd.error().message().find("even width and height"), std::string::npos);
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder_.c_str(), 1);
  const auto without = write_video(folder_ / "a.mp4", body, {});
  setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().message(),
            "video: needs ffmpeg, which is not installed; install the Debian package 'ffmpeg'");
  Trajectory empty;
  MovingBody nothing = flying_box(empty);
  EXPECT_FALSE(write_video(folder_ / "a.mp4", nothing, {}));
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace borelli::test::video_test
