#include "tests/suite/phantom_suite.hpp"

namespace borelli::suite {
namespace {

constexpr double far = 1e9;

Case standing(const char* name, const char* what, std::uint64_t seed) {
  Case c{name, what, {}, {}, {}};
  c.body.variation = seed;
  c.grid.spacing = {2, 2, 2};
  // fractions of a voxel, so that no cut of the body lies exactly between two layers
  c.grid.offset = {0.13, -0.29, 0.21};
  c.scan.noise_hu = 10;
  c.scan.seed = seed;
  return c;
}

Case scanned(const char* name, const char* what, std::uint64_t seed, const Eigen::Vector3d& low,
             const Eigen::Vector3d& high) {
  Case c = standing(name, what, seed);
  c.grid.crop_low = low;
  c.grid.crop_high = high;
  return c;
}

void put_hand_on_hip(PhantomOptions& body, const std::string& side) {
  body.pose_deg["shoulder" + side + "_abduction"] = 50;
  body.pose_deg["shoulder" + side + "_flexion"] = 0;
  body.pose_deg["shoulder" + side + "_rotation"] = 88;
  body.pose_deg["elbow" + side + "_flexion"] = 98;
  body.pose_deg["wrist" + side + "_flexion"] = 55;
}

const std::vector<std::string> left_arm{"upper_arm_left", "forearm_left", "hand_left"},
    both_arms{"upper_arm_left", "upper_arm_right", "forearm_left",
              "forearm_right",  "hand_left",       "hand_right"},
    thighs{"thigh_left", "thigh_right"}, legs{"thigh_left", "thigh_right", "shank_left", "shank_right"};

void add_standing(std::vector<Case>& all) {
  all.push_back(standing("man", "a man", 11));
  Case c = standing("woman", "a woman", 12);
  c.body.sex = Sex::female;
  all.push_back(c);

  c = standing("arms_on_trunk", "arms on the trunk", 13);
  for (const char* side : {"left", "right"}) {
    c.body.pose_deg[std::string("shoulder_") + side + "_abduction"] = side[0] == 'l' ? 1 : 2.5;
    c.body.pose_deg[std::string("shoulder_") + side + "_flexion"] = 0;
    c.body.pose_deg[std::string("elbow_") + side + "_flexion"] = 4;
  }
  c.touching = both_arms;
  c.touching.insert(c.touching.end(), thighs.begin(), thighs.end());
  all.push_back(c);

  c = standing("thighs_touch", "thighs touch", 14);
  c.body.sex = Sex::female;
  c.body.mass_kg = 72;
  c.body.pose_deg = {{"hip_left_abduction", -2}, {"hip_right_abduction", -2.5}};
  c.touching = legs;
  all.push_back(c);

  c = standing("knees_bent", "knees bent", 15);
  c.body.pose_deg = {{"hip_left_flexion", 32},
                     {"hip_right_flexion", 24},
                     {"knee_left_flexion", 75},
                     {"knee_right_flexion", 55}};
  all.push_back(c);
}

void add_raised_and_folded(std::vector<Case>& all) {
  Case c = standing("arm_overhead", "one arm over the head", 16);
  c.body.pose_deg = {{"shoulder_left_abduction", 150},
                     {"shoulder_left_flexion", 0},
                     {"shoulder_left_rotation", -85},
                     {"elbow_left_flexion", 80}};
  c.touching = left_arm;
  all.push_back(c);

  c = standing("hand_on_hip", "hand on the hip", 17);
  put_hand_on_hip(c.body, "_left");
  c.touching = left_arm;
  all.push_back(c);

  // the back of the hand on the iliac wing: their bones are about 8 mm apart
  c.name = "hand_behind_hip", c.what = "hand behind the hip";
  c.body.sex = Sex::female;
  c.body.variation = 206, c.scan.seed = 205;
  all.push_back(c);

  c = standing("hands_on_hips", "both hands on the hips", 305);
  for (const char* side : {"_left", "_right"}) put_hand_on_hip(c.body, side);
  c.body.sex = Sex::female;
  c.touching = both_arms;
  all.push_back(c);

  c = standing("arms_on_chest", "arms crossed before the chest", 30);
  c.body.variation.reset();
  c.body.pose_deg = {{"shoulder_left_flexion", 45},   {"shoulder_left_abduction", 0},
                     {"shoulder_left_rotation", 75},  {"elbow_left_flexion", 95},
                     {"shoulder_right_flexion", 30},  {"shoulder_right_abduction", 0},
                     {"shoulder_right_rotation", 65}, {"elbow_right_flexion", 110}};
  c.touching = both_arms;
  all.push_back(c);

  c = standing("knees_folded", "knees bent beyond a right angle", 611);
  c.body.pose_deg = {{"hip_left_flexion", 25},
                     {"hip_right_flexion", 20},
                     {"knee_left_flexion", 105},
                     {"knee_right_flexion", 97}};
  all.push_back(c);
}

void add_partial(std::vector<Case>& all) {
  all.push_back(scanned("cut_at_neck", "ends at the neck", 18, {-far, -far, -far}, {far, far, 1560}));
  all.push_back(scanned("cut_at_knee", "ends above the knees", 19, {-far, -far, 590}, {far, far, far}));
  all.push_back(scanned("cut_on_left", "the left arm half outside", 20, {-far, -far, -far}, {225, far, far}));

  all.push_back(scanned("one_side", "the left side alone", 31, {0, -far, -far}, {far, far, far}));
  all.push_back(scanned("legs_alone", "legs alone", 32, {-far, -far, -far}, {far, far, 620}));
  all.push_back(scanned("head_alone", "a head alone", 33, {-far, -far, 1560}, {far, far, far}));
}

void add_unusual_bodies(std::vector<Case>& all) {
  Case c = standing("obese", "BMI 40", 21);
  c.body.mass_kg = 121;
  c.touching = both_arms;
  c.touching.insert(c.touching.end(), legs.begin(), legs.end());
  all.push_back(c);

  c = standing("child", "a child of six", 22);
  c.body.child = true;
  all.push_back(c);
}

void add_unusual_scans(std::vector<Case>& all) {
  Case c = standing("slices_5mm", "slices of 5 mm", 23);
  c.grid.spacing = {2, 2, 5};
  all.push_back(c);

  c = standing("noise_30", "noise of 30 HU", 24);
  c.body.sex = Sex::female;
  c.scan.noise_hu = 30;
  all.push_back(c);

  c = standing("metal_hip", "a metal hip with streaks", 25);
  c.body.metal_hip = "right";
  c.scan.streaks_hu = 400;
  all.push_back(c);

  c = standing("table_blanket", "table and blanket", 26);
  c.scan.table = c.scan.blanket = true;
  all.push_back(c);

  c = standing("oblique", "oblique", 27);
  c.body.sex = Sex::female;
  c.grid.rotation_deg = {8, -5, 12};
  all.push_back(c);

  c = standing("tilt_15", "gantry tilted by 15 degrees", 28);
  c.grid.tilt_deg = 15;
  all.push_back(c);

  c = standing("field_of_view", "a field of view of 0.5 m", 29);
  c.scan.field_of_view = 500;
  all.push_back(c);
}

}  // namespace

std::vector<Case> cases() {
  std::vector<Case> all;
  add_standing(all);
  add_raised_and_folded(all);
  add_partial(all);
  add_unusual_bodies(all);
  add_unusual_scans(all);
  return all;
}

}  // namespace borelli::suite
