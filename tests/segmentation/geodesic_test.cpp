#include "segmentation/grid/geodesic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <random>
#include <vector>

namespace borelli {
namespace {

Volume<float> even_cost(std::array<std::int64_t, 3> size, double step, float cost) {
  Volume<float> out;
  out.grid.size = size;
  out.grid.axes = step * Eigen::Matrix3d::Identity();
  out.voxels.assign(out.grid.count(), cost);
  return out;
}
Volume<std::uint8_t> no_seeds(const Grid& grid) { return {grid, std::vector<std::uint8_t>(grid.count(), 0)}; }

// length of a path that steps along faces, edges and corners (Borgefors 1986, with exact step lengths)
double octile(double a, double b, double c) {
  double d[3] = {std::abs(a), std::abs(b), std::abs(c)};
  std::sort(d, d + 3);
  return std::sqrt(3.0) * d[0] + std::sqrt(2.0) * (d[1] - d[0]) + (d[2] - d[1]);
}

TEST(Geodesic, UniformCostGivesThePathLength) {
  const auto cost = even_cost({15, 11, 9}, 2, 3);
  auto seeds = no_seeds(cost.grid);
  seeds.at(4, 5, 2) = 7;
  const auto found = geodesic({cost, 0}, seeds, true);
  for (std::int64_t k = 0; k < 9; ++k)
    for (std::int64_t j = 0; j < 11; ++j)
      for (std::int64_t i = 0; i < 15; ++i) {
        const double expected =
            3 * 2 *
            octile(static_cast<double>(i - 4), static_cast<double>(j - 5), static_cast<double>(k - 2));
        EXPECT_NEAR(found.length(i, j, k), expected, 1e-4 * (1 + expected));  // sums of floats
        EXPECT_EQ(found.owner.at(i, j, k), 7);
      }
  const auto path = found.path_to(static_cast<std::uint32_t>(cost.grid.offset(14, 5, 2)));
  EXPECT_EQ(path.size(), 11U);
  EXPECT_EQ(path.front(), cost.grid.offset(4, 5, 2));
}

TEST(Geodesic, PathsAvoidWallsAndSeedsShareTheRest) {
  auto cost = even_cost({21, 21, 1}, 1, 1);
  for (std::int64_t j = 0; j < 20; ++j) cost.at(10, j, 0) = no_path;
  auto seeds = no_seeds(cost.grid);
  seeds.at(9, 0, 0) = 1;
  seeds.at(20, 20, 0) = 2;
  const auto found = geodesic({cost, 0}, seeds, false);
  EXPECT_EQ(found.owner.at(10, 3, 0), 0);  // the wall itself
  EXPECT_EQ(found.owner.at(11, 0, 0),
            2);  // two voxels from seed 1 across the wall, but nearer to seed 2 around it
  EXPECT_EQ(found.owner.at(9, 15, 0), 1);
  EXPECT_EQ(nearest_seeds({cost, 0}, seeds).voxels, found.owner.voxels);
}

TEST(Geodesic, PathsStopAtTheRequestedLength) {
  const auto cost = even_cost({30, 3, 3}, 1, 1);
  auto seeds = no_seeds(cost.grid);
  seeds.at(0, 1, 1) = 1;
  const auto found = geodesic({cost, 0}, seeds, false, 10.5F);
  EXPECT_EQ(found.owner.at(10, 1, 1), 1);
  EXPECT_EQ(found.owner.at(11, 1, 1), 0);
  EXPECT_EQ(found.length(11, 1, 1), no_path);
}

TEST(Geodesic, HandlesAVolumeOfOneColumn) {
  auto cost = even_cost({1, 1 << 10, 1 << 10}, 1, 1);
  auto seeds = no_seeds(cost.grid);
  seeds.at(0, 3, 1000) = 5;
  const auto found = geodesic({cost, 2}, seeds, false);
  EXPECT_EQ(found.owner.at(0, 0, 0), 5);
  EXPECT_NEAR(found.length(0, 3, 0), 1000, 1e-3);
}

// Lengths of the cheapest paths from voxels of one label: the textbook form of Dijkstra's algorithm, with a
// heap, in double.
std::vector<double> lengths_from(const Volume<float>& cost, const Volume<std::uint8_t>& seeds, int label) {
  const Grid& g = cost.grid;
  using Entry = std::pair<double, std::array<std::int64_t, 3>>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::vector<double> length(g.count(), no_path);
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (seeds.at(i, j, k) == label && cost.at(i, j, k) != no_path)
          length[g.offset(i, j, k)] = 0, queue.push({0, {i, j, k}});
  while (!queue.empty()) {
    const auto [here, at] = queue.top();
    queue.pop();
    if (here > length[g.offset(at[0], at[1], at[2])]) continue;
    for (std::int64_t c = -1; c <= 1; ++c)
      for (std::int64_t b = -1; b <= 1; ++b)
        for (std::int64_t a = -1; a <= 1; ++a) {
          const std::array<std::int64_t, 3> to{at[0] + a, at[1] + b, at[2] + c};
          if (!g.holds(to[0], to[1], to[2])) continue;
          const double costs = 0.5 * (static_cast<double>(cost.at(at[0], at[1], at[2])) +
                                      static_cast<double>(cost.at(to[0], to[1], to[2])));
          const double there =
              here + g.axes(0, 0) * std::sqrt(static_cast<double>(a * a + b * b + c * c)) * costs;
          double& known = length[g.offset(to[0], to[1], to[2])];
          if (there < known) known = there, queue.push({there, to});
        }
  }
  return length;
}

TEST(Geodesic, PathsAcrossHalvesAreTheCheapest) {
  // large enough for two parallel halves, with walls that lead paths from half to half
  const std::int64_t nx = 121, ny = 90, nz = 100;
  auto cost = even_cost({nx, ny, nz}, 1.5, 1);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.1F, 2);
  for (auto& c : cost.voxels) c = uniform(random);
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t i = 0; i < nx; ++i)
      for (std::int64_t j = 15; j < ny; j += 15)  // open at alternating ends
        if (j % 2 ? i > 5 : i + 5 < nx) cost.at(i, j, k) = no_path;
  auto seeds = no_seeds(cost.grid);
  seeds.at(2, 2, 50) = 1;
  seeds.at(nx - 3, 3, 10) = 2;
  seeds.at(60, 40, 90) = 1;
  seeds.at(61, 70, 5) = 2;
  seeds.at(50, 15, 5) = 3;  // in a wall
  ASSERT_EQ(cost.at(50, 15, 5), no_path);
  const std::array by_label{lengths_from(cost, seeds, 1), lengths_from(cost, seeds, 2)};

  const auto places = [&](int threads) { return Places(cost, threads); };
  for (const float longest : {no_path, 60.0F}) {
    const auto found = geodesic(places(2), seeds, true, longest);
    EXPECT_EQ(geodesic(places(1), seeds, true, longest).owner.voxels, found.owner.voxels);
    std::size_t reached = 0, worst = 0;
    double most_off = 0;
    for (std::size_t o = 0; o < cost.grid.count(); ++o) {
      const double shortest = std::min(by_label[0][o], by_label[1][o]), off = 1e-5 * (1 + shortest);
      const auto owner = found.owner.voxels[o];
      if (owner == 0) {
        EXPECT_GT(shortest, longest == no_path ? 1e30 : static_cast<double>(longest) - off);
        continue;
      }
      ++reached;
      ASSERT_LE(owner, 2);
      EXPECT_LT(shortest, static_cast<double>(longest) + off);
      EXPECT_NEAR(by_label[owner - 1U][o], shortest, off);
      if (const double now = std::abs(found.length(o) - shortest) / (1 + shortest); now > most_off)
        most_off = now, worst = o;
    }
    EXPECT_GT(reached, cost.grid.count() / 20);
    EXPECT_LT(most_off, 1e-5) << worst;  // sums of about a hundred floats
    // a path's length is the sum of its steps
    std::size_t far = 0;
    for (std::size_t o = 0; o < cost.grid.count(); ++o)
      if (found.owner.voxels[o] && (!found.owner.voxels[far] || found.length(o) > found.length(far))) far = o;
    const auto path = found.path_to(static_cast<std::uint32_t>(far));
    EXPECT_EQ(seeds.voxels[path.front()], found.owner.voxels[far]);
    double sum = 0;
    bool left = false, right = false;
    for (std::size_t n = 0; n < path.size(); ++n) {
      (path[n] % nx < nx / 2 ? left : right) = true;
      if (n == 0) continue;
      const auto place = [&](std::uint32_t o) {
        return Eigen::Vector3d(static_cast<double>(o % nx), static_cast<double>(o / nx % ny),
                               static_cast<double>(o / nx / ny));
      };
      const Eigen::Vector3d step = place(path[n]) - place(path[n - 1]);
      ASSERT_EQ(step.cwiseAbs().maxCoeff(), 1);
      sum += 1.5 * step.norm() * 0.5 *
             (static_cast<double>(cost.voxels[path[n]]) + static_cast<double>(cost.voxels[path[n - 1]]));
    }
    EXPECT_NEAR(sum, found.length(far), 1e-5 * (1 + sum));
    EXPECT_TRUE(left && right);
  }
}

}  // namespace
}  // namespace borelli
