// The part colours differ for every kind of colour vision.
//
// Simulation of dichromats: Machado, Oliveira & Fernandes (2009) IEEE TVCG 15:1291, table of severity 1.0, on
// linear sRGB. Distance: CIEDE2000 after Sharma, Wu & Dalal (2005) Color Res. Appl. 30:21, whose test pairs
// check our own formula first.
#include "pipeline/files/palette.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <string>

namespace borelli {
namespace {

constexpr double degree = std::numbers::pi / 180;

double ciede2000(const Eigen::Vector3d& lab1, const Eigen::Vector3d& lab2) {
  const auto seventh = [](double c) {
    return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7)));
  };
  const double g = 0.5 * (1 - seventh((std::hypot(lab1[1], lab1[2]) + std::hypot(lab2[1], lab2[2])) / 2));
  const double a1 = (1 + g) * lab1[1], a2 = (1 + g) * lab2[1];
  const double c1 = std::hypot(a1, lab1[2]), c2 = std::hypot(a2, lab2[2]);
  const auto hue = [](double a, double b) {
    const double h = std::atan2(b, a) / degree;
    return h < 0 ? h + 360 : h;
  };
  const double h1 = hue(a1, lab1[2]), h2 = hue(a2, lab2[2]);
  double turn = h2 - h1;
  if (turn > 180) turn -= 360;
  if (turn < -180) turn += 360;
  if (c1 * c2 == 0) turn = 0;
  double mean_hue = (h1 + h2) / 2;
  if (std::abs(h1 - h2) > 180) mean_hue += h1 + h2 < 360 ? 180 : -180;
  const double mean_l = (lab1[0] + lab2[0]) / 2, mean_c = (c1 + c2) / 2;
  const double t = 1 - 0.17 * std::cos((mean_hue - 30) * degree) + 0.24 * std::cos(2 * mean_hue * degree) +
                   0.32 * std::cos((3 * mean_hue + 6) * degree) -
                   0.20 * std::cos((4 * mean_hue - 63) * degree);
  const double lift = (mean_l - 50) * (mean_l - 50);
  const double dl = (lab2[0] - lab1[0]) / (1 + 0.015 * lift / std::sqrt(20 + lift));
  const double dc = (c2 - c1) / (1 + 0.045 * mean_c);
  const double dh = 2 * std::sqrt(c1 * c2) * std::sin(turn / 2 * degree) / (1 + 0.015 * mean_c * t);
  const double spread = 30 * std::exp(-std::pow((mean_hue - 275) / 25, 2));
  const double rotation = -std::sin(2 * spread * degree) * 2 * seventh(mean_c);
  return std::sqrt(dl * dl + dc * dc + dh * dh + rotation * dc * dh);
}

Eigen::Vector3d linear(Colour colour) {
  Eigen::Vector3d rgb(colour.red, colour.green, colour.blue);
  return (rgb / 255).unaryExpr(
      [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); });
}

Eigen::Vector3d lab(const Eigen::Vector3d& linear_rgb) {
  Eigen::Matrix3d xyz_of_rgb;  // sRGB primaries, white point D65
  xyz_of_rgb << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920,
      0.9503041;
  const Eigen::Vector3d xyz =
      (xyz_of_rgb * linear_rgb.cwiseMax(0.0).cwiseMin(1.0)).array() / Eigen::Array3d(0.95047, 1.0, 1.08883);
  const Eigen::Vector3d f = xyz.unaryExpr(
      [](double v) { return v > 216.0 / 24389 ? std::cbrt(v) : (24389.0 / 27 * v + 16) / 116; });
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

std::array<Eigen::Matrix3d, 4> visions() {
  std::array<Eigen::Matrix3d, 4> all;
  all[0].setIdentity();
  all[1] << 0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998;
  all[2] << 0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881;
  all[3] << 1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.303900;
  return all;
}

// Smallest distance between two parts' colours over the four kinds of vision.
double distance(std::string_view one, std::string_view other) {
  double smallest = 1e9;
  for (const auto& vision : visions())
    smallest = std::min(smallest, ciede2000(lab(vision * linear(part_colour(one))),
                                            lab(vision * linear(part_colour(other)))));
  return smallest;
}

// Sharma, Wu & Dalal (2005), table 1, pairs 1, 9, 17 and 25; printed to four digits.
TEST(Palette, ColourDistanceMatchesThePublishedPairs) {
  EXPECT_NEAR(ciede2000({50, 2.6772, -79.7751}, {50, 0, -82.7485}), 2.0425, 1e-4);
  EXPECT_NEAR(ciede2000({50, 2.4900, -0.0010}, {50, -2.4900, 0.0009}), 7.1792, 1e-4);
  EXPECT_NEAR(ciede2000({50, 2.5, 0}, {73, 25, -18}), 27.1492, 1e-4);
  EXPECT_NEAR(ciede2000({60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}), 1.2644, 1e-4);
}

// The limits are stated at the head of the palette's file. A distance of about 2.3 is just noticeable side by
// side (Mahy, Van Eycken & Oosterlinck (1994) Color Res. Appl. 19:105), so 15 is plain at a glance.
TEST(Palette, TouchingPartsDifferForEveryColourVision) {
  for (const Part& part : parts)
    if (!part.parent.empty()) {
      EXPECT_GE(distance(part.name, part.parent), 15) << part.name;
    }
  for (const std::string side : {"left", "right"}) {
    EXPECT_GE(distance("upper_arm_" + side, "middle_trunk"), 15) << side;
    EXPECT_GE(distance("forearm_" + side, "middle_trunk"), 15) << side;
    EXPECT_GE(distance("forearm_" + side, "lower_trunk"), 15) << side;
    EXPECT_GE(distance("hand_" + side, "lower_trunk"), 15) << side;
    EXPECT_GE(distance("hand_" + side, "thigh_" + side), 15) << side;
  }
}

TEST(Palette, LeftPartsAreLighterAndAllPartsDiffer) {
  for (const std::string limb : {"upper_arm", "forearm", "hand", "thigh", "shank", "foot"}) {
    EXPECT_GE(distance(limb + "_left", limb + "_right"), 13) << limb;
    EXPECT_GT(lab(linear(part_colour(limb + "_left")))[0], lab(linear(part_colour(limb + "_right")))[0])
        << limb;
  }
  for (std::size_t one = 1; one < parts.size(); ++one)
    for (std::size_t other = one + 1; other < parts.size(); ++other)
      EXPECT_GE(distance(parts[one].name, parts[other].name), 7)
          << parts[one].name << " and " << parts[other].name;
}

}  // namespace
}  // namespace borelli
