#include "inertia/moments.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

// sheared, anisotropic, left-handed or not
Grid oblique_grid() {
  Grid grid;
  grid.size = {75, 9, 21};
  grid.axes << 1.5, 0.2, -0.1, 0.1, -0.8, 0.9, -0.3, 0.25, 2.5;
  grid.origin << 12, -300, 900;
  return grid;
}

struct Scan {
  LabelMap labels;
  GreyVolume grey;
  GreyWeights weights;
};

// the same with rows that hold long runs
Grid grid_of_long_rows() {
  Grid grid = oblique_grid();
  grid.size = {701, 5, 9};
  return grid;
}

// Runs of random labels with lengths from 1 to most of a row, random grey values, and an irregular weight
// table.
Scan random_scan(const Grid& grid, unsigned seed) {
  std::mt19937 random(seed);
  Scan scan;
  scan.labels.grid = scan.grey.grid = grid;
  std::uniform_int_distribution<int> label(0, 5), grey(-32768, 32767),
      log_length(0, static_cast<int>(std::log2(grid.size[0])));
  while (scan.labels.voxels.size() < grid.count()) {
    std::uniform_int_distribution<int> length(1, 1 + (1 << log_length(random)));
    const int value = label(random);
    scan.labels.voxels.insert(scan.labels.voxels.end(), static_cast<std::size_t>(length(random)),
                              static_cast<std::uint8_t>(value == 5 ? 255 : value));
  }
  scan.labels.voxels.resize(grid.count());
  for (std::size_t n = 0; n < grid.count(); ++n)
    scan.grey.voxels.push_back(static_cast<std::int16_t>(grey(random)));
  for (int g = -32768; g < 32768; ++g) scan.weights.push_back(1000 + 300 * std::sin(0.01 * g));
  return scan;
}

// Mass, centre and tensor of one label, voxel by voxel in the world, in long double.
Inertial direct_sum(const Scan& scan, int label) {
  using Real = long double;
  using Vec = Eigen::Matrix<Real, 3, 1>;
  const Grid& grid = scan.labels.grid;
  Real mass = 0;
  Vec first = Vec::Zero();
  Eigen::Matrix<Real, 3, 3> second = Eigen::Matrix<Real, 3, 3>::Zero();
  const auto each = [&](const auto& visit) {
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
      for (std::int64_t j = 0; j < grid.size[1]; ++j)
        for (std::int64_t i = 0; i < grid.size[0]; ++i)
          if (scan.labels.at(i, j, k) == label) {
            const Vector3d index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
            const auto weight = scan.weights[static_cast<std::size_t>(scan.grey.at(i, j, k) + 32768)];
            visit(static_cast<Real>(weight * grid.voxel_volume() * 1e-9),
                  Vec(grid.point(index).cast<Real>() / 1000));
          }
  };
  each([&](Real m, const Vec& p) { mass += m, first += m * p; });
  const Vec centre = first / mass;
  each([&](Real m, const Vec& p) {
    const Vec r = p - centre;
    second += m * (r.squaredNorm() * Eigen::Matrix<Real, 3, 3>::Identity() - r * r.transpose());
  });
  return {static_cast<double>(mass), centre.cast<double>(), second.cast<double>()};
}

// masses relative; centres in m over a body of about 0.1 m; tensors relative to the largest entry
void expect_equal(const Inertial& found, const Inertial& expected, double tolerance) {
  EXPECT_NEAR(found.mass, expected.mass, tolerance * expected.mass);
  EXPECT_LT((found.centre - expected.centre).norm(), tolerance);
  EXPECT_LT((found.tensor - expected.tensor).cwiseAbs().maxCoeff(),
            tolerance * expected.tensor.cwiseAbs().maxCoeff());
}

TEST(Moments, EqualSumsOverSingleVoxelsOnAnObliqueGrid) {
  for (const Grid& grid : {oblique_grid(), grid_of_long_rows()}) {
    const Scan scan = random_scan(grid, 1);
    const auto moments = label_moments(scan.labels, scan.grey, scan.weights);
    ASSERT_TRUE(moments);
    for (const int label : {1, 2, 3, 4, 255})
      // 14000 (31000) terms of 1e-16 add up as their square root; second - mean^2 loses 2 digits
      expect_equal(
          to_inertial((*moments)[static_cast<std::size_t>(label)], scan.labels.grid, Sampling::points),
          direct_sum(scan, label), 1e-12);
  }
}

TEST(Moments, CountVoxelsAndIgnoreOutside) {
  const Scan scan = random_scan(oblique_grid(), 2);
  const auto weighted = label_moments(scan.labels, scan.grey, scan.weights);
  const auto plain = label_moments(scan.labels);
  ASSERT_TRUE(weighted && plain);
  std::array<std::int64_t, 256> count{};
  for (const auto label : scan.labels.voxels) ++count[label];
  count[0] = 0;
  for (std::size_t label = 0; label < 256; ++label) {
    EXPECT_EQ((*weighted)[label].voxels, count[label]);
    EXPECT_EQ((*plain)[label].voxels, count[label]);
    EXPECT_EQ((*plain)[label].weight, static_cast<double>(count[label]));
  }
  // |det axes| by hand: 1.5 (-0.8 * 2.5 - 0.9 * 0.25) - 0.2 (0.1 * 2.5 + 0.9 * 0.3) - 0.1 (0.1 * 0.25 - 0.8 *
  // 0.3)
  EXPECT_NEAR(scan.labels.grid.voxel_volume(), 3.42, 1e-12);
}

TEST(Moments, WithoutGreyValuesEqualWeightOne) {
  for (const Grid& grid : {oblique_grid(), grid_of_long_rows()}) {
    Scan scan = random_scan(grid, 3);
    scan.weights.assign(65536, 1);
    const auto weighted = label_moments(scan.labels, scan.grey, scan.weights);
    const auto plain = label_moments(scan.labels);
    ASSERT_TRUE(weighted && plain);
    for (std::size_t label = 0; label < 256; ++label) {  // whole numbers below 2^53: exact
      EXPECT_EQ((*weighted)[label].weight, (*plain)[label].weight);
      EXPECT_EQ((*weighted)[label].first, (*plain)[label].first);
      EXPECT_EQ((*weighted)[label].second, (*plain)[label].second);
    }
  }
}

TEST(Moments, AreIndependentOfThreads) {
  Grid grid = oblique_grid();
  grid.size[2] = 67;  // several slabs, the last one short
  const Scan scan = random_scan(grid, 4);
  const auto one = label_moments(scan.labels, scan.grey, scan.weights, 1);
  for (const int threads : {2, 5, 64}) {
    const auto many = label_moments(scan.labels, scan.grey, scan.weights, threads);
    ASSERT_TRUE(one && many);
    for (std::size_t label = 0; label < 256; ++label) {
      EXPECT_EQ((*one)[label].weight, (*many)[label].weight);
      EXPECT_EQ((*one)[label].first, (*many)[label].first);
      EXPECT_EQ((*one)[label].second, (*many)[label].second);
    }
  }
}

// The same voxels in another basis of the lattice: voxel i of the first grid is voxel U i + shift of the
// second, where U is an integer matrix with determinant +-1. A straight grid becomes sheared or turned, but
// every voxel keeps its position.
Scan rebased(const Scan& scan, const Eigen::Matrix3i& U) {
  const Grid& from = scan.labels.grid;
  Eigen::Vector3i low = Eigen::Vector3i::Zero(), high = low;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3i index;
    for (int a = 0; a < 3; ++a)
      index[a] = (corner >> a & 1) ? static_cast<int>(from.size[static_cast<std::size_t>(a)]) - 1 : 0;
    low = low.cwiseMin(U * index);
    high = high.cwiseMax(U * index);
  }
  Grid to;
  for (int a = 0; a < 3; ++a) to.size[static_cast<std::size_t>(a)] = high[a] - low[a] + 1;
  to.axes = from.axes * U.cast<double>().inverse();
  to.origin = from.origin + to.axes * low.cast<double>();
  Scan there;
  there.weights = scan.weights;
  there.labels.grid = there.grey.grid = to;
  there.labels.voxels.assign(to.count(), 0);
  there.grey.voxels.assign(to.count(), 0);
  for (int k = 0; k < from.size[2]; ++k)
    for (int j = 0; j < from.size[1]; ++j)
      for (int i = 0; i < from.size[0]; ++i) {
        const Eigen::Vector3i n = U * Eigen::Vector3i(i, j, k) - low;
        there.labels.at(n[0], n[1], n[2]) = scan.labels.at(i, j, k);
        there.grey.at(n[0], n[1], n[2]) = scan.grey.at(i, j, k);
      }
  return there;
}

TEST(Moments, AgreeOnStraightRotatedAndShearedGrids) {
  Grid grid;
  grid.size = {20, 17, 15};
  grid.axes = Vector3d(1.2, 0.7, 3).asDiagonal();
  grid.origin << -100, 20, 5;
  const Scan scan = random_scan(grid, 5);
  const auto here = label_moments(scan.labels, scan.grey, scan.weights);
  ASSERT_TRUE(here);
  Eigen::Matrix3i turned, sheared, doubly_sheared;
  turned << 0, 0, -1, 1, 0, 0, 0, 1, 0;
  sheared << 1, 0, 2, 0, 1, -1, 0, 0, 1;
  doubly_sheared << 1, 1, 0, 0, 1, -2, 1, 1, 1;
  for (const auto& U : {turned, sheared, doubly_sheared}) {
    ASSERT_EQ(std::abs(U.determinant()), 1);
    const Scan other = rebased(scan, U);
    const auto there = label_moments(other.labels, other.grey, other.weights);
    ASSERT_TRUE(there);
    for (std::size_t label : {1u, 3u, 255u})
      expect_equal(to_inertial((*there)[label], other.labels.grid, Sampling::points),
                   to_inertial((*here)[label], grid, Sampling::points), 1e-12);
  }
}

// An ellipsoid of 1000 kg/m^3 with semi-axes 15, 40, 90 mm (a hand) on a grid, sampled at points or averaged
// over voxels.
struct Ellipsoid {
  Vector3d semi{15, 40, 90};  // mm
  Matrix3d R;
  Vector3d centre;

  Inertial exact() const {
    const double mass = 1000 * 4. / 3 * std::numbers::pi * semi.prod() * 1e-9;
    const Vector3d s = (1e-3 * semi).array().square();
    return Inertial{mass, Vector3d::Zero(),
                    (mass / 5 * Vector3d(s[1] + s[2], s[0] + s[2], s[0] + s[1])).asDiagonal()}
        .expressed_in(R, 1e-3 * centre);
  }
  double level(const Vector3d& p) const {
    return (semi.cwiseInverse().asDiagonal() * (R.transpose() * (p - centre))).norm();
  }
};

Scan draw(const Ellipsoid& body, const Grid& grid, bool averages) {
  Scan scan;
  scan.labels.grid = scan.grey.grid = grid;
  scan.labels.voxels.assign(grid.count(), 0);
  scan.grey.voxels.assign(grid.count(), 0);
  for (int g = -32768; g < 32768; ++g) scan.weights.push_back(g < 0 ? 0 : g);
  constexpr int parts = 10;  // per axis of a mixed voxel: occupancy to about 1e-3
  // a voxel extends by half its diagonal at most, and the level grows by at most 1 per smallest semi-axis
  const double reach = 0.5 * grid.axes.cwiseAbs().rowwise().sum().norm() / body.semi.minCoeff();
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        const Vector3d index(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const double level = body.level(grid.point(index));
        double occupancy = level < 1;
        if (averages && std::abs(level - 1) <= reach) {
          int inside = 0;
          for (int n = 0; n < parts * parts * parts; ++n) {
            const Vector3d sub(n % parts, n / parts % parts, n / parts / parts);
            inside += body.level(grid.point(index + (sub.array() + 0.5).matrix() / parts -
                                            Vector3d::Constant(0.5))) < 1;
          }
          occupancy = inside / double(parts * parts * parts);
        }
        scan.labels.at(i, j, k) = occupancy > 0;
        scan.grey.at(i, j, k) = static_cast<std::int16_t>(std::lround(1000 * occupancy));
      }
  return scan;
}

struct Errors {
  double mass = 0, centre_mm = 0, tensor = 0;  // relative, mm, relative to the largest entry
};

// A grid of voxels of volume h^3 in random pose about a body, straight and cubic or anisotropic and skewed.
enum class Shape { cubic, skewed };

Grid random_grid(const Ellipsoid& body, double h, Shape shape, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Grid grid;
  grid.axes = h * random_rotation(random);
  if (shape == Shape::skewed) {
    grid.axes *= Vector3d(0.8, 1, 1.25).asDiagonal();
    grid.axes.col(2) += 0.3 * unit(random) * grid.axes.col(0) + 0.3 * unit(random) * grid.axes.col(1);
  }
  const Matrix3d to_index = grid.axes.inverse();
  Vector3d half;  // half size of the body's box in indices
  for (int a = 0; a < 3; ++a) {
    half[a] = (to_index.row(a) * body.R * body.semi.asDiagonal()).norm() + 3 +
              unit(random);  // random position within a voxel
    grid.size[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(2 * half[a]) + 1;
  }
  grid.origin = body.centre - grid.axes * half;
  return grid;
}

Ellipsoid random_hand(double h, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {{15, 40, 90}, random_rotation(random), h * Vector3d(unit(random), unit(random), unit(random))};
}

Moments moments_of(const Scan& scan) { return (*label_moments(scan.labels, scan.grey, scan.weights))[1]; }

// root mean square over poses
Errors rms_errors(double h, Shape shape, bool averages, Sampling sampling, int poses) {
  std::mt19937 random(7);
  Errors rms;
  for (int n = 0; n < poses; ++n) {
    const Ellipsoid body = random_hand(h, random);
    const Grid grid = random_grid(body, h, shape, random);
    const Inertial exact = body.exact(),
                   found = to_inertial(moments_of(draw(body, grid, averages)), grid, sampling);
    rms.mass += std::pow(found.mass / exact.mass - 1, 2) / poses;
    rms.centre_mm += (1e3 * (found.centre - exact.centre)).squaredNorm() / poses;
    rms.tensor +=
        std::pow((found.tensor - exact.tensor).cwiseAbs().maxCoeff() / exact.tensor.maxCoeff(), 2) / poses;
  }
  return {std::sqrt(rms.mass), std::sqrt(rms.centre_mm), std::sqrt(rms.tensor)};
}

TEST(Moments, OfAHandConvergeWithTheSquareOfTheVoxelSize) {
  const Errors at_4mm = rms_errors(4, Shape::cubic, false, Sampling::points, 48),
               at_2mm = rms_errors(2, Shape::cubic, false, Sampling::points, 48);
  // At 2 mm the errors of a hand in random poses are .069 % of mass, .038 mm and .15 % of a moment (rms of 24
  // poses, from another program). Two such rms values differ by about 20 %; the test allows 2.5 times that.
  EXPECT_LT(at_2mm.mass, 1.5 * 0.00069);
  EXPECT_LT(at_2mm.centre_mm, 1.5 * 0.038);
  EXPECT_LT(at_2mm.tensor, 1.5 * 0.0015);
  // h^2 would be 4
  EXPECT_GT(at_4mm.mass / at_2mm.mass, 2.5);
  EXPECT_GT(at_4mm.tensor / at_2mm.tensor, 2.5);
}

TEST(Moments, OfAveragesUseSheppardsCorrectionOnSkewedGrids) {
  const Errors with = rms_errors(4, Shape::skewed, true, Sampling::averages, 8),
               without = rms_errors(4, Shape::skewed, true, Sampling::points, 8);
  // h^2/12 is 1.3 mm^2 on each of two axes of a mean square radius of (40^2 + 90^2)/5 mm^2: 0.14 %. After the
  // correction, the occupancy's error remains: 1e-3 in each of about 2000 mixed voxels of 3500, in total
  // 1e-3/sqrt(2000).
  EXPECT_GT(without.tensor, 0.0014);
  EXPECT_LT(with.tensor, 0.0001);
  EXPECT_LT(with.mass, 0.0001);
}

TEST(Moments, OfALabelMapNeedNoCubeMoment) {
  // Over random positions of the grid, the sum over voxel centres is an unbiased estimate of the integral;
  // adding the cube's own h^2/12 per axis would bias it. Trace of the second moments about the true centre, 8
  // mm.
  constexpr int poses = 2000;
  constexpr double h = 8;
  std::mt19937 random(8);
  double mean = 0, square = 0;
  for (int n = 0; n < poses; ++n) {
    const Ellipsoid body = random_hand(h, random);
    const Grid grid = random_grid(body, h, Shape::cubic, random);
    const Inertial found = to_inertial(moments_of(draw(body, grid, false)), grid, Sampling::points);
    const double error = found.tensor_about(1e-3 * body.centre).trace() / body.exact().tensor.trace() - 1;
    mean += error / poses;
    square += error * error / poses;
  }
  const double deviation_of_mean = std::sqrt((square - mean * mean) / poses);
  EXPECT_LT(std::abs(mean), 4 * deviation_of_mean);
  const double cubes_own = 3 * h * h / 12 / ((15. * 15 + 40. * 40 + 90. * 90) / 5);
  EXPECT_GT(std::abs(mean + cubes_own), 4 * deviation_of_mean);
}

TEST(Moments, OfASliverStayPhysical) {
  // a part one voxel thick has a smaller second moment than h^2/12
  LabelMap labels;
  labels.grid.size = {30, 20, 4};
  labels.voxels.assign(labels.grid.count(), 0);
  for (std::int64_t j = 3; j < 15; ++j)
    for (std::int64_t i = 2; i < 27; ++i) labels.at(i, j, 2) = 1;
  const auto moments = label_moments(labels);
  ASSERT_TRUE(moments);
  const Inertial sliver = to_inertial((*moments)[1], labels.grid, Sampling::averages);
  EXPECT_TRUE(check_physical(sliver, "sliver"));
  EXPECT_EQ(sliver.tensor, to_inertial((*moments)[1], labels.grid, Sampling::points).tensor);
}

TEST(Moments, OfAnEmptyLabelAreZero) {
  const Scan scan = random_scan(oblique_grid(), 8);
  const auto moments = label_moments(scan.labels, scan.grey, scan.weights);
  ASSERT_TRUE(moments);
  const Inertial empty = to_inertial((*moments)[99], scan.labels.grid, Sampling::averages);
  EXPECT_EQ(empty.mass, 0);
  EXPECT_EQ(empty.tensor, Matrix3d::Zero());
}

TEST(Moments, RefuseVolumesOnDifferentGrids) {
  Scan scan = random_scan(oblique_grid(), 9);
  Scan moved = scan;
  moved.grey.grid.origin[0] += 1;
  EXPECT_FALSE(label_moments(moved.labels, moved.grey, moved.weights));
  Scan cut = scan;
  cut.grey.voxels.pop_back();
  EXPECT_FALSE(label_moments(cut.labels, cut.grey, cut.weights));
  scan.weights.pop_back();
  EXPECT_FALSE(label_moments(scan.labels, scan.grey, scan.weights));
}

}  // namespace
}  // namespace borelli
