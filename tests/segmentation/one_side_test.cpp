// One side of a body, cut lengthwise by the scan's side at the middle, beyond it and before it: the parts in
// view, against the phantom's exact labels.
#include <cmath>
#include <map>
#include <string>

#include "tests/segmentation/dice.hpp"
#include "tests/segmentation/scanned_body.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct OneSide : ScannedBody {
  std::string own, other;
  const PartFinding& part(const std::string& name) const {
    return found.part[static_cast<std::size_t>(part_label(name))];
  }
};

// `beyond`: mm past the middle that are in view
OneSide scanned(std::uint64_t variation, Sex sex, bool left, double beyond) {
  const auto grid_of = [&](const Phantom& body) {
    GridOptions grid;
    grid.spacing.setConstant(4);
    const double middle = body.landmarks.find("mid_hip")->second.point[0];
    (left ? grid.crop_low : grid.crop_high)[0] = middle + (left ? -beyond : beyond);
    return grid;
  };
  return {scanned_body(variation, sex, grid_of), left ? "_left" : "_right", left ? "_right" : "_left"};
}

// Parts of the visible side are whole unless the crop cuts them; the other side has none.
void expect_own_side(const OneSide& of) {
  const auto agree = dice(of.found.labels, of.exact);
  for (const std::string limb : {"upper_arm", "forearm", "hand", "thigh", "shank", "foot"}) {
    EXPECT_GT(agree[static_cast<std::size_t>(part_label(limb + of.own))], 0.95) << limb;
    if (limb != "thigh") {
      EXPECT_EQ(name_of(of.part(limb + of.own).coverage), "whole") << limb;
      EXPECT_EQ(name_of(of.part(limb + of.other).coverage), "absent") << limb;
      EXPECT_EQ(of.part(limb + of.other).volume, 0) << limb;
    }
  }
  for (const char* name : {"upper_trunk", "middle_trunk", "lower_trunk"})
    EXPECT_EQ(name_of(of.part(name).coverage), "cut") << name;
}

// Every point is within its deviation.
void expect_within_deviations(const OneSide& of) {
  for (const auto& [name, mark] : of.found.landmarks) {
    const auto exact = of.body.landmarks.find(name);
    if (exact == of.body.landmarks.end()) continue;
    const Vector3d error = mark.point - exact->second.point;
    for (int c = 0; c < 3; ++c) EXPECT_LT(std::abs(error[c]), 2 * mark.deviation) << name << ' ' << c;
  }
}

void expect_dice(const OneSide& of, const std::map<std::string, double>& least) {
  const auto agree = dice(of.found.labels, of.exact);
  for (const auto& [name, value] : least)
    EXPECT_GT(agree[static_cast<std::size_t>(part_label(name))], value) << name;
}

TEST(OneSide, IsSegmentedWhenCutAtTheMiddle) {
  for (const bool left : {true, false}) {
    const OneSide of = scanned(left ? 301 : 302, left ? Sex::male : Sex::female, left, 0);
    expect_own_side(of);
    expect_within_deviations(of);
    // half a navel is not recognised: its level comes from proportions, so adjacent parts are less exact
    expect_dice(of, {{"head", 0.98}, {"upper_trunk", 0.98}, {"middle_trunk", 0.9}, {"lower_trunk", 0.9}});
    EXPECT_EQ(name_of(of.part("head").coverage), "cut");
    EXPECT_EQ(of.part("thigh" + of.other).volume, 0);
    EXPECT_FALSE(of.found.landmarks.contains("hip" + of.other));
    EXPECT_LT(of.found.landmarks.at("hip" + of.own).deviation, 3);
  }
}

// The spine shows the middle, so a piece of the other thigh is distinguished from this one.
TEST(OneSide, IsSegmentedWhenCutBeyondTheMiddle) {
  for (const bool left : {true, false}) {
    const OneSide of = scanned(left ? 301 : 302, left ? Sex::male : Sex::female, left, 40);
    expect_own_side(of);
    expect_within_deviations(of);
    expect_dice(of, {{"head", 0.98},
                     {"upper_trunk", 0.98},
                     {"middle_trunk", 0.98},
                     {"lower_trunk", 0.98},
                     {"thigh" + of.other, 0.95}});
    EXPECT_EQ(name_of(of.part("thigh" + of.own).coverage), "whole");
    EXPECT_EQ(name_of(of.part("head").coverage), "cut");
    EXPECT_EQ(name_of(of.part("thigh" + of.other).coverage), "cut");
  }
}

// Half a hip and a slice of the other leg are in view. That leg's knee is not found, so a note says that its
// thigh includes the shank.
TEST(OneSide, IsSegmentedWhenCutThroughTheOtherHip) {
  const OneSide of = scanned(301, Sex::male, true, 90);
  expect_own_side(of);
  expect_within_deviations(of);
  expect_dice(of, {{"head", 0.98}, {"upper_trunk", 0.98}, {"middle_trunk", 0.98}, {"lower_trunk", 0.98}});
  EXPECT_EQ(name_of(of.part("head").coverage), "whole");
  EXPECT_EQ(name_of(of.part("thigh_right").coverage), "cut");
  EXPECT_LE(of.part("thigh_right").confidence, 0.2);
}

// Neither spine nor sternum nor navel is in view: the ends of the trunk's parts are estimates, and are marked
// so.
TEST(OneSide, IsSegmentedWhenCutBeforeTheMiddle) {
  for (const bool left : {true, false}) {
    const OneSide of = scanned(left ? 301 : 302, left ? Sex::male : Sex::female, left, -40);
    expect_own_side(of);
    expect_within_deviations(of);
    expect_dice(of, {{"head", 0.95}, {"upper_trunk", 0.9}, {"middle_trunk", 0.8}, {"lower_trunk", 0.8}});
    for (const char* name : {"head", "upper_trunk", "middle_trunk", "lower_trunk"})
      EXPECT_LT(of.part(name).confidence, 0.5) << name;
    EXPECT_EQ(name_of(of.part("thigh" + of.own).coverage), "cut");
    EXPECT_EQ(of.part("thigh" + of.other).volume, 0);
  }
}

}  // namespace
}  // namespace borelli
