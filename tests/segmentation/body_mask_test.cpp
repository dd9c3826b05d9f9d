#include "segmentation/body/body_mask.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

// a torso (a cylinder along z) with air in and around it, on a 3 mm grid
class BodyMask : public ::testing::Test {
 protected:
  void SetUp() override {
    auto& g = scan_.hu.grid;
    g.size = {100, 90, 70};
    g.axes = 3 * Eigen::Matrix3d::Identity();
    g.origin = Vector3d(-150, -130, 0);
    scan_.hu.voxels.assign(g.count(), -1000);
    scan_.seen = {g, std::vector<std::uint8_t>(g.count(), 1)};
    paint(40, [](const Vector3d& p) { return std::hypot(p[0], p[1]) < 80 && p[2] > 20; });
  }

  template <class Holds>
  void paint(int hu, const Holds& holds) {
    const auto& g = scan_.hu.grid;
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i)
          if (holds(point(i, j, k))) scan_.hu.at(i, j, k) = static_cast<std::int16_t>(hu);
  }
  Vector3d point(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return scan_.hu.grid.point(i, j, k);
  }
  // share of the points where `holds` is true that are in the mask
  template <class Holds>
  double share(const Mask& mask, const Holds& holds) const {
    const auto& g = mask.grid;
    std::int64_t in = 0, all = 0;
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i)
          if (holds(point(i, j, k))) ++all, in += mask.at(i, j, k);
    return static_cast<double>(in) / static_cast<double>(all);
  }

  WorkVolume scan_;
};

TEST_F(BodyMask, RemovesATableThatTouchesTheBack) {
  const auto table = [](const Vector3d& p) { return p[1] > 79 && p[1] < 86; };
  const auto clear_table = [&](const Vector3d& p) { return table(p) && std::abs(p[0]) > 50; };
  paint(-100, table);
  const Mask body = body_mask(scan_);
  EXPECT_EQ(share(body, clear_table), 0);
  EXPECT_EQ(share(body, [](const Vector3d& p) { return std::hypot(p[0], p[1]) < 76 && p[2] > 24; }), 1);
}

TEST_F(BodyMask, KeepsEarsAndFingers) {
  const auto ear = [](const Vector3d& p) {
    return p[0] > 75 && p[0] < 105 && std::abs(p[1]) < 4 && p[2] > 100 && p[2] < 160;
  };
  const auto finger = [](const Vector3d& p) {
    return std::hypot(p[0], p[2] - 120) < 7 && p[1] < -75 && p[1] > -125;
  };
  paint(40, ear);
  paint(40, finger);
  const Mask body = body_mask(scan_);
  EXPECT_EQ(share(body, ear), 1);
  EXPECT_EQ(share(body, finger), 1);
}

TEST_F(BodyMask, KeepsASeparateFingerAndRemovesObjects) {
  // rods along z, 16 mm thick, 7 mm off the torso: of flesh with a bone, of flesh alone, of dense material
  const auto rod = [](double x, double y, double r) {
    return [=](const Vector3d& p) { return std::hypot(p[0] - x, p[1] - y) < r && std::abs(p[2] - 120) < 22; };
  };
  const auto finger = rod(95, 0, 8), pad = rod(-95, 0, 8), bar = rod(0, -95, 8), far = rod(125, 0, 8);
  paint(40, finger), paint(1000, rod(95, 0, 4));
  paint(40, pad);
  paint(1000, bar);
  Mask body = body_mask(scan_);
  EXPECT_EQ(share(body, finger), 1);
  EXPECT_EQ(share(body, pad), 0);
  EXPECT_EQ(share(body, bar), 0);
  EXPECT_EQ(connected_regions(body).list.size(), 1u) << "joined, so that its flesh has an owner";
  // a finger 35 mm away does not belong to this body
  paint(-1000, finger), paint(40, far), paint(1000, rod(125, 0, 4));
  EXPECT_EQ(share(body_mask(scan_), far), 0);
}

TEST_F(BodyMask, FillsLungsAndGutEvenIfOpen) {
  const auto lung = [](const Vector3d& p) { return (p - Vector3d(30, 0, 110)).norm() < 35; };
  const auto windpipe = [](const Vector3d& p) { return std::hypot(p[1], p[2] - 110) < 6 && p[0] > 30; };
  const auto cut_lung = [](const Vector3d& p) { return (p - Vector3d(-40, 0, 207)).norm() < 30; };
  paint(-850, lung);
  paint(-1000, windpipe);
  paint(-850, cut_lung);
  const Mask body = body_mask(scan_);
  EXPECT_EQ(share(body, lung), 1);
  EXPECT_EQ(share(body, cut_lung), 1);
}

TEST_F(BodyMask, KeepsGapsBetweenSkinsOpen) {
  // an arm beside the torso that touches it along two lines only
  paint(40, [](const Vector3d& p) { return std::hypot(p[0] - 112, p[1]) < 30 && p[2] > 20; });
  paint(40, [](const Vector3d& p) {
    return p[0] > 70 && p[0] < 90 && std::abs(p[1]) > 12 && std::abs(p[1]) < 20 && p[2] > 20;
  });
  const auto crevice = [](const Vector3d& p) {
    return std::hypot(p[0], p[1]) > 82 && std::hypot(p[0] - 112, p[1]) > 32 && p[0] > 0 &&
           std::abs(p[1]) < 9 && p[2] > 60 && p[2] < 150;
  };
  EXPECT_LT(share(body_mask(scan_), crevice), 0.05) << "the open end lets the outside air in";
}

TEST_F(BodyMask, AirAloneGivesNoBody) {
  for (auto& v : scan_.hu.voxels) v = -1000;
  EXPECT_EQ(share(body_mask(scan_), [](const Vector3d&) { return true; }), 0);
}

}  // namespace
}  // namespace borelli
