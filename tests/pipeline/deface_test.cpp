// Defacing of heads drawn in closed form, in any orientation: the distance of the rest from the face; nothing
// else changes.
#include "pipeline/export/deface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

/// A head after an adult's measures (Gordon et al. (1989) ANSUR, medians of men: 197 mm long, 152 mm wide,
/// the chin 232 mm below the vertex) on a neck and shoulders. In its own axes (left, front, up) from the
/// middle of the cranium; the whole head is nodded and turned about the neck's top, the rest stands.
struct Head {
  double nod = 0, turn = 0;  // rad: positive: looks down, looks to the left
  Vector3d pivot{0, -25, -100};

  Eigen::Matrix3d rotation() const {
    return (Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * Eigen::AngleAxisd(-nod, Vector3d::UnitX())).matrix();
  }
  Vector3d turned(const Vector3d& p) const { return pivot + rotation() * (p - pivot); }
  Vector3d back(const Vector3d& p) const { return pivot + rotation().transpose() * (p - pivot); }

  static bool ball(const Vector3d& p, const Vector3d& middle, const Vector3d& radii) {
    return (p - middle).cwiseQuotient(radii).squaredNorm() <= 1;
  }
  static bool skull(const Vector3d& p) {  // in the head's own axes
    const bool socket = ball(p, {32, 92, -25}, {14, 14, 10}) || ball(p, {-32, 92, -25}, {14, 14, 10});
    return !socket && (ball(p, {0, 0, 0}, {76, 98.5, 100}) ||   // cranium
                       ball(p, {0, 35, -65}, {60, 55, 62}) ||   // face
                       ball(p, {0, 72, -112}, {28, 18, 18}) ||  // chin
                       ball(p, {0, 95, -55}, {13, 20, 18}) ||   // nose
                       ball(p, {78, -10, -40}, {10, 16, 30}) || ball(p, {-78, -10, -40}, {10, 16, 30}));
  }
  /// Part label at a position (left, front, up).
  std::uint8_t part(const Vector3d& p) const {
    if (p[2] > -150) {
      const bool neck = p[2] < -60 && std::hypot(p[0], p[1] + 25) < 58;
      return neck || skull(back(p)) ? static_cast<std::uint8_t>(part_label("head")) : std::uint8_t{0};
    }
    return ball(p, {0, -20, -230}, {200, 110, 95}) ? static_cast<std::uint8_t>(part_label("upper_trunk"))
                                                   : std::uint8_t{0};
  }
};

Vector3d lps(const Vector3d& p) { return {p[0], -p[1], p[2]}; }  // of (left, front, up)

LabelMap drawn(const Head& head) {
  LabelMap labels;
  labels.grid.size = {148, 170, 110};
  labels.grid.axes = Eigen::AngleAxisd(0.15, Vector3d(0.3, 0.2, 1).normalized()).toRotationMatrix() *
                     Eigen::DiagonalMatrix<double, 3>(2, -2, 3);
  labels.grid.origin = -labels.grid.axes * Vector3d(74, 85, 62);
  for (const Part& part : parts) labels.names.emplace_back(part.name);
  for (std::int64_t k = 0; k < labels.grid.size[2]; ++k)
    for (std::int64_t j = 0; j < labels.grid.size[1]; ++j)
      for (std::int64_t i = 0; i < labels.grid.size[0]; ++i)
        labels.voxels.push_back(head.part(lps(labels.grid.point(i, j, k))));
  return labels;
}

GreyVolume grey_of(const LabelMap& labels) {
  GreyVolume grey;
  grey.grid = labels.grid;
  for (const auto label : labels.voxels) grey.voxels.push_back(label ? 40 : -990);
  return grey;
}

Vector3d place(const Thumbnail& copy, std::size_t at) {
  const auto [nx, ny, nz] = copy.size;
  const auto n = static_cast<std::int64_t>(at);
  return copy.origin + copy.spacing * Vector3d(static_cast<double>(n % nx), static_cast<double>(n / nx % ny),
                                               static_cast<double>(n / nx / ny));
}

/// Points of the face's surface: the foremost of each column between brow and chin, sideways up to the outer
/// corners of the eyes (45 mm from the middle) and of the mouth (28 mm) and to the chin's sides (16 mm).
std::vector<Vector3d> face_of(const Head& head) {
  std::vector<Vector3d> places;
  for (double z = -120; z <= 0; z += 5)
    for (double x = -45; x <= 45; x += 3) {
      if (std::abs(x) > (z < -90 ? 16 : z < -50 ? 28 : 45)) continue;
      for (double y = 130; y > 40; y -= 0.5)
        if (Head::skull({x, y, z})) {
          places.push_back(lps(head.turned({x, y, z})));
          break;
        }
    }
  return places;
}

class Deface : public testing::TestWithParam<std::pair<double, double>> {
 protected:
  static constexpr double degree = std::numbers::pi / 180;
  const Head head{GetParam().first * degree, GetParam().second* degree};
  const LabelMap labels = drawn(head);
  const std::uint8_t label = static_cast<std::uint8_t>(part_label("head"));
};

TEST_P(Deface, RemovesEverythingNearTheFace) {
  const auto cut = face_cut(labels, {});
  ASSERT_TRUE(cut);
  Thumbnail copy = thumbnail(nullptr, &labels);
  deface(copy, *cut);
  std::vector<Vector3d> left;
  for (std::size_t at = 0; at < copy.labels.size(); ++at)
    if (copy.labels[at] == label) left.push_back(place(copy, at));
  const auto face = face_of(head);
  ASSERT_GT(face.size(), 300u);
  double nearest = 1e300, mean = 0;
  Vector3d where = Vector3d::Zero();
  for (const Vector3d& place : face) {
    double distance = 1e300;
    for (const Vector3d& other : left) distance = std::min(distance, (other - place).squaredNorm());
    if (std::sqrt(distance) < nearest) nearest = std::sqrt(distance), where = place;
    mean += std::sqrt(distance) / static_cast<double>(face.size());
  }
  // the plane should lie 0.22 x 197 = 43 mm behind the foremost line; this head's eye corners lie 20 to 25 mm
  // behind that line, the sides of mouth and chin up to 28 mm
  EXPECT_GT(nearest, 10) << "from " << head.back(lps(where)).transpose();
  EXPECT_GT(mean, 25);
}

TEST_P(Deface, ChangesNothingElse) {
  const auto cut = face_cut(labels, {});
  ASSERT_TRUE(cut);
  const GreyVolume grey = grey_of(labels);
  const Thumbnail whole = thumbnail(&grey, &labels);
  Thumbnail copy = whole;
  deface(copy, *cut);
  std::size_t taken = 0, all = 0;
  for (std::size_t at = 0; at < copy.labels.size(); ++at) {
    const Vector3d p = lps(place(copy, at)), own = head.back(p);
    all += whole.labels[at] == label;
    taken += whole.labels[at] == label && copy.labels[at] == 0;
    // unchanged below the head, and in the head behind the front of the ears
    if (p[2] < -155 || (whole.labels[at] != 0 && p[2] > -60 && own[1] < 10)) {
      ASSERT_EQ(copy.labels[at], whole.labels[at]) << p.transpose();
      ASSERT_EQ(copy.grey[at], whole.grey[at]) << p.transpose();
    }
    if (whole.labels[at] == label && copy.labels[at] == 0) {
      ASSERT_EQ(copy.grey[at], 0) << p.transpose();
    }
  }
  EXPECT_GT(static_cast<double>(taken), 0.08 * static_cast<double>(all));
  EXPECT_LT(static_cast<double>(taken), 0.3 * static_cast<double>(all));
}

TEST_P(Deface, MeshIsClosedAndEndsAtThePlane) {
  const auto cut = face_cut(labels, {});
  ASSERT_TRUE(cut);
  const MeshOptions options{0.001, 2, {}};
  const auto before = part_meshes(labels, options).value();
  auto meshes = before;
  ASSERT_TRUE(deface(meshes, labels, *cut, options));
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0].name, "head");
  EXPECT_TRUE(is_closed(meshes[0]));
  EXPECT_EQ(meshes[1].points, before[1].points);  // the trunk's
  const auto foremost = [&](const Mesh& mesh) {
    double far = -1e300;
    for (const auto& p : mesh.points)
      far = std::max(far, (1e3 * p.cast<double>() - cut->point).dot(cut->front));
    return far;
  };
  EXPECT_GT(foremost(before[0]), 40);  // the nose
  EXPECT_LT(foremost(meshes[0]), 3);   // a voxel's thickness, and the tolerance of decimation
}

INSTANTIATE_TEST_SUITE_P(Poses, Deface,
                         testing::Values(std::pair{0.0, 0.0}, std::pair{12.0, 0.0}, std::pair{-20.0, 0.0},
                                         std::pair{0.0, 25.0}, std::pair{10.0, -30.0}),
                         [](const auto& at) {
                           const auto say = [](double deg) {
                             return (deg < 0 ? "minus" : "") + std::to_string(std::lround(std::abs(deg)));
                           };
                           return "Nod" + say(at.param.first) + "Turn" + say(at.param.second);
                         });

TEST(DefaceWithoutAHead, ShowsNoGreyValueOutsideTheParts) {
  LabelMap labels = drawn({});
  for (auto& voxel : labels.voxels)
    if (voxel == part_label("head")) voxel = 0;
  EXPECT_FALSE(face_cut(labels, {}));
  GreyVolume grey = grey_of(drawn({}));
  Thumbnail copy = thumbnail(&grey, &labels);
  keep_labelled(copy);
  std::size_t shown = 0;
  for (std::size_t at = 0; at < copy.grey.size(); ++at) {
    if (copy.labels[at] == 0) {
      ASSERT_EQ(copy.grey[at], 0);
    }
    shown += copy.grey[at] > 0;
  }
  EXPECT_GT(shown, 1000u);
  labels.names.clear();
  EXPECT_FALSE(face_cut(labels, {}));
}

}  // namespace
}  // namespace borelli
