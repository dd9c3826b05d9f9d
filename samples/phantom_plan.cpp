#include "samples/phantom_plan.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

namespace borelli {
namespace {

using Eigen::AngleAxisd, Eigen::Matrix3d, Eigen::Vector3d;

// Lengths: de Leva (1996) Table 4, with mean stature and mass of the samples there. Breadth of hips: Bell,
// Brand & Pedersen 1989 (the hip centre lies 14 to 18 % of the inter-ASIS distance medial of the ASIS).
// Breadth of shoulders: common adult values. The flesh factors are ours, chosen to bring the masses close to
// de Leva's fractions.
constexpr Proportions male{.stature = 1741,
                           .mass_kg = 73.0,
                           .head = 242.9,
                           .thorax = 242.1,
                           .sternum = 170.7,
                           .abdomen = 215.5,
                           .pelvis = 145.7,
                           .thigh = 422.2,
                           .shank = 440.3,
                           .foot = 258.1,
                           .upper_arm = 281.7,
                           .forearm = 268.9,
                           .palm = 86.2,
                           .hand = 187.9,
                           .ankle = 64,
                           .asis_up = 75,
                           .hip_half = 88,
                           .asis_half = 118,
                           .shoulder_half = 186,
                           .bone = 1,
                           .arm_bone = 1,
                           .leg_bone = 1,
                           .head_flesh = 1.070,
                           .neck_flesh = 1.070,
                           .chest_flesh = 1.03,
                           .chest_depth = 1.104,
                           .waist_flesh = 1.070,
                           .pelvis_flesh = 1.064,
                           .arm_flesh = 0.941,
                           .forearm_flesh = 0.980,
                           .hand_flesh = 1.175,
                           .thigh_flesh = 1.062,
                           .shank_flesh = 0.931,
                           .foot_flesh = 1.008,
                           .fat = 1};
constexpr Proportions female{.stature = 1735,
                             .mass_kg = 61.9,
                             .head = 243.7,
                             .thorax = 228.0,
                             .sternum = 142.5,
                             .abdomen = 205.3,
                             .pelvis = 181.5,
                             .thigh = 368.5,
                             .shank = 438.6,
                             .foot = 228.3,
                             .upper_arm = 275.1,
                             .forearm = 264.3,
                             .palm = 78.0,
                             .hand = 170.1,
                             .ankle = 60,
                             .asis_up = 95,
                             .hip_half = 88,
                             .asis_half = 112,
                             .shoulder_half = 166,
                             .bone = 0.86,
                             .arm_bone = 1,
                             .leg_bone = 1,
                             .head_flesh = 0.953,
                             .neck_flesh = 0.953,
                             .chest_flesh = 0.95,
                             .chest_depth = 1.105,
                             .waist_flesh = 0.931,
                             .pelvis_flesh = 1.076,
                             .arm_flesh = 0.857,
                             .forearm_flesh = 0.838,
                             .hand_flesh = 1.092,
                             .thigh_flesh = 1.023,
                             .shank_flesh = 0.900,
                             .foot_flesh = 0.966,
                             .fat = 1.25};

// A child of six years, built at an adult's stature and then scaled: a large head, short legs. Stature and
// mass: WHO Child Growth Standards, median of boys of six (1.16 m, 20.5 kg). Lengths and breadths: rounded,
// within the ranges of Snyder et al. (1977, UMTRI-77-17) for that age.
constexpr double child_stature = 1.16;  // m
constexpr Proportions child{.stature = 1741,
                            .mass_kg = 69.3,
                            .head = 315,
                            .thorax = 228,
                            .sternum = 160,
                            .abdomen = 190,
                            .pelvis = 140,
                            .thigh = 396,
                            .shank = 392,
                            .foot = 258,
                            .upper_arm = 272,
                            .forearm = 238,
                            .palm = 84,
                            .hand = 186,
                            .ankle = 74,
                            .asis_up = 72,
                            .hip_half = 82,
                            .asis_half = 112,
                            .shoulder_half = 174,
                            .bone = 0.93,
                            .arm_bone = 1,
                            .leg_bone = 1,
                            .head_flesh = 1.32,
                            .neck_flesh = 1.0,
                            .chest_flesh = 0.93,
                            .chest_depth = 1.12,
                            .waist_flesh = 0.96,
                            .pelvis_flesh = 0.93,
                            .arm_flesh = 0.88,
                            .forearm_flesh = 0.93,
                            .hand_flesh = 1.15,
                            .thigh_flesh = 0.95,
                            .shank_flesh = 0.89,
                            .foot_flesh = 1.06,
                            .fat = 1.1};

// Uniform random numbers from a seed (splitmix64, Steele, Lea & Flood 2014).
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}
  double between(double least, double most) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return least + (most - least) * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

// Measures vary independently, except those tied by bones or planes: so scaling segments does not turn one
// such body into another.
void vary(Proportions& p, std::uint64_t seed) {
  const Proportions usual = p;
  Draw draw(seed);
  const auto by = [&](double share, std::initializer_list<double*> measures) {
    const double factor = 1 + draw.between(-share, share);
    for (double* const m : measures) *m *= factor;
  };
  by(0.05, {&p.head});
  by(0.05, {&p.thorax, &p.sternum});
  by(0.05, {&p.abdomen});
  by(0.05, {&p.pelvis, &p.asis_up});
  by(0.07, {&p.thigh});
  by(0.07, {&p.shank});
  by(0.06, {&p.foot});
  by(0.07, {&p.upper_arm});
  by(0.07, {&p.forearm});
  by(0.06, {&p.palm, &p.hand});
  by(0.06, {&p.ankle});
  by(0.05, {&p.hip_half, &p.asis_half});
  by(0.05, {&p.shoulder_half});
  by(0.03, {&p.head_flesh, &p.neck_flesh});
  by(0.04, {&p.chest_flesh});
  by(0.03, {&p.chest_depth});
  by(0.05, {&p.waist_flesh});
  by(0.04, {&p.pelvis_flesh});
  by(0.06, {&p.arm_flesh});
  by(0.05, {&p.forearm_flesh});
  by(0.03, {&p.hand_flesh});
  by(0.06, {&p.thigh_flesh});
  by(0.05, {&p.shank_flesh});
  by(0.02, {&p.foot_flesh});
  by(0.15, {&p.fat});
  // bones only become thinner, each limb's independently, and never wider than the flesh about their joints
  // allows
  const auto no_wider = [&](double Proportions::*flesh) { return std::min(1.0, p.*flesh / usual.*flesh); };
  p.shoulder_half = std::min(p.shoulder_half, usual.shoulder_half * p.chest_flesh / usual.chest_flesh);
  p.bone *= no_wider(&Proportions::chest_flesh) * draw.between(0.93, 0.99);
  p.arm_bone *= no_wider(&Proportions::arm_flesh) * draw.between(0.88, 0.98);
  p.leg_bone *= std::min(no_wider(&Proportions::shank_flesh), no_wider(&Proportions::foot_flesh)) *
                draw.between(0.90, 0.99);
}

Matrix3d about_x(double deg) {
  return AngleAxisd(deg * std::numbers::pi / 180, Vector3d::UnitX()).toRotationMatrix();
}
Matrix3d about_y(double deg) {
  return AngleAxisd(deg * std::numbers::pi / 180, Vector3d::UnitY()).toRotationMatrix();
}
Matrix3d about_z(double deg) {
  return AngleAxisd(deg * std::numbers::pi / 180, Vector3d::UnitZ()).toRotationMatrix();
}

std::string angle_name(const PoseAngle& angle, std::string_view side) {
  return fmt::format("{}_{}_{}", angle.joint, side, angle.motion);
}

// Heavy bodies abduct the arms more. Nobody stands quite straight or symmetrically: `draw` varies each joint
// a little, within its range.
double standing_angle(const PoseAngle& angle, double build, std::optional<Draw>& draw) {
  const bool arms = angle.joint == "shoulder" && angle.motion == "abduction";
  const double straight = arms ? angle.standing + 25 * std::max(0.0, build - 1) : angle.standing;
  if (!draw) return straight;
  constexpr double most = 7;  // degrees
  return std::clamp(straight + draw->between(-most, most), std::max(angle.least, arms ? 8.0 : angle.least),
                    angle.most);
}

Result<std::map<std::string, double>> all_angles(const PhantomOptions& options, double build) {
  const std::map<std::string, double>& asked = options.pose_deg;
  std::optional<Draw> draw;
  if (options.variation) draw.emplace(*options.variation + 1);
  std::map<std::string, double> angles;
  std::string known;
  for (const PoseAngle& angle : pose_angles)
    for (const std::string_view side : side_name) {
      const std::string name = angle_name(angle, side);
      angles[name] = standing_angle(angle, build, draw);
      if (angle.joint == "hip" && angle.motion == "abduction") angles[name] = std::max(0.0, angles[name]);
      known += (known.empty() ? "" : ", ") + name;
      const auto it = asked.find(name);
      if (it == asked.end()) continue;
      if (!(it->second >= angle.least && it->second <= angle.most))
        return bad_use("pose", fmt::format("{} = {} deg is out of range; the phantom allows {} to {} deg",
                                           name, it->second, angle.least, angle.most));
      angles[name] = it->second;
    }
  for (const auto& [name, value] : asked)
    if (!angles.contains(name))
      return bad_use("pose", fmt::format("unknown angle '{}'; choose from {}", name, known));
  return angles;
}

void place_levels(BodyPlan& plan) {
  const Proportions& p = plan.size;
  // de Leva's lengths and the ankle's height do not add up exactly to the stature: axial lengths get one
  // factor
  const double axial = (p.stature - p.ankle) / (p.head + p.thorax + p.abdomen + p.pelvis + p.thigh + p.shank);
  plan.size.thigh *= axial;
  plan.size.shank *= axial;
  plan.size.head *= axial;
  plan.neck = p.stature - plan.size.head;
  plan.notch = plan.neck - (p.thorax - p.sternum) * axial;
  plan.xiphion = plan.neck - p.thorax * axial;
  plan.omphalion = plan.xiphion - p.abdomen * axial;
  plan.hip = plan.omphalion - p.pelvis * axial;
}

void place_leg(BodyPlan& plan, int side, const Frame& half, const std::map<std::string, double>& angles) {
  const auto angle = [&](const char* joint, const char* motion) {
    return angles.at(fmt::format("{}_{}_{}", joint, side_name[static_cast<std::size_t>(side)], motion));
  };
  const Proportions& p = plan.size;
  // standing: legs slightly apart, feet pointing slightly outwards
  const Matrix3d thigh = axes_along({-0.02, 0.0, 1.0}, Vector3d::UnitX());
  const Matrix3d shank = axes_along({-0.012, -0.02, 1.0}, Vector3d::UnitX()), foot = about_z(8);
  const double reach = p.thigh * thigh(2, 2) + p.shank * shank(2, 2);
  const Vector3d hip(p.hip_half, 0, p.ankle + reach);
  const Matrix3d turned = about_y(-angle("hip", "abduction")) * about_x(-angle("hip", "flexion"));
  const std::size_t s = static_cast<std::size_t>(side);
  plan.thigh[s] = half.then({turned * thigh, hip});
  plan.shank[s] = plan.thigh[s].then(
      {about_x(angle("knee", "flexion")) * thigh.transpose() * shank, Vector3d(0, 0, -p.thigh)});
  plan.foot[s] = plan.shank[s].then(
      {shank.transpose() * about_x(-angle("ankle", "dorsiflexion")) * foot, Vector3d(0, 0, -p.shank)});
}

void place_arm(BodyPlan& plan, int side, const Frame& half, const std::map<std::string, double>& angles) {
  const auto angle = [&](const char* joint, const char* motion) {
    return angles.at(fmt::format("{}_{}_{}", joint, side_name[static_cast<std::size_t>(side)], motion));
  };
  const Proportions& p = plan.size;
  const std::size_t s = static_cast<std::size_t>(side);
  const Vector3d shoulder(p.shoulder_half, 2, plan.neck - 88);
  plan.upper_arm[s] =
      half.then({about_y(-angle("shoulder", "abduction")) * about_x(-angle("shoulder", "flexion")) *
                     about_z(-angle("shoulder", "rotation")),
                 shoulder});
  plan.forearm[s] =
      plan.upper_arm[s].then({about_x(-angle("elbow", "flexion")), Vector3d(0, 0, -p.upper_arm)});
  plan.hand[s] = plan.forearm[s].then({about_y(angle("wrist", "flexion")), Vector3d(0, 0, -p.forearm)});
}

void mark(BodyPlan& plan, const std::string& name, const Vector3d& point, double radius = 0) {
  plan.landmarks[name] = {.point = point, .deviation = 0, .radius = radius, .source = "exact"};
}

void mark_trunk(BodyPlan& plan) {
  const double waist = plan.size.waist_flesh, bone = plan.size.bone;
  mark(plan, "neck", {0, 0, plan.neck});
  mark(plan, "cervicale", {0, 42 * bone, plan.neck});
  mark(plan, "vertex", {0, -18, plan.size.stature});
  mark(plan, "suprasternale", {0, -52 * bone, plan.notch});
  mark(plan, "xiphion", {0, -92 * bone, plan.xiphion});
  mark(plan, "spine_upper", {0, 36 * bone, plan.xiphion});
  mark(plan, "spine_lower", {0, 20 * bone, plan.omphalion});
  mark(plan, "omphalion", {0, -117 * waist, plan.omphalion});
  mark(plan, "mid_hip", {0, 0, plan.hip});
}

void mark_limbs(BodyPlan& plan, int side, const Frame& half) {
  const std::size_t s = static_cast<std::size_t>(side);
  const std::string at = fmt::format("_{}", side_name[s]);
  const Proportions& p = plan.size;
  const double bone = p.bone, arm = p.arm_bone, leg = p.leg_bone;
  mark(plan, "asis" + at, half.point({p.asis_half, -50 * bone, plan.asis}));
  mark(plan, "shoulder" + at, plan.upper_arm[s].origin, humeral_head * arm);
  mark(plan, "elbow" + at, plan.forearm[s].origin, trochlea * arm);
  mark(plan, "elbow_medial" + at, plan.forearm[s].point({-30 * arm, 0, 0}));
  mark(plan, "elbow_lateral" + at, plan.forearm[s].point({30 * arm, 0, 0}));
  mark(plan, "wrist" + at, plan.hand[s].origin);
  mark(plan, "metacarpale_3" + at, plan.hand[s].point({0, -8, -p.palm}));
  mark(plan, "dactylion_3" + at, plan.hand[s].point({0, -8, -p.hand}));
  mark(plan, "hip" + at, plan.thigh[s].origin, femoral_head * leg);
  mark(plan, "knee" + at, plan.shank[s].origin, knee_condyle * leg);
  const Frame knee = plan.thigh[s].then({Matrix3d::Identity(), Vector3d(0, 0, -p.thigh)});
  mark(plan, "knee_medial" + at, knee.point({-40 * leg, 0, 0}));
  mark(plan, "knee_lateral" + at, knee.point({40 * leg, 0, 0}));
  mark(plan, "ankle" + at, plan.foot[s].origin, talar_dome * leg);
  const Frame ankle = plan.shank[s].then({Matrix3d::Identity(), Vector3d(0, 0, -p.shank)});
  mark(plan, "medial_malleolus" + at, ankle.point({-26 * leg, 0, -6 * leg}));
  mark(plan, "lateral_malleolus" + at, ankle.point({25.5 * leg, 6 * leg, -14 * leg}));
  mark(plan, "heel" + at, plan.foot[s].point({0, 52.0 / 258.1 * p.foot, 30 - p.ankle}));
  mark(plan, "toe_tip" + at, plan.foot[s].point({0, -206.1 / 258.1 * p.foot, 10 - p.ankle}));
}

}  // namespace

Proportions proportions(const PhantomOptions& options) {
  Proportions p = options.child ? child : options.sex == Sex::male ? male : female;
  if (options.variation) vary(p, *options.variation);
  return p;
}

double usual_stature(const PhantomOptions& options) {
  return options.child ? child_stature : proportions(options).stature * 1e-3;
}

std::vector<HalfSpace> BodyPlan::region(int part) const {
  std::vector<HalfSpace> spaces;
  for (const Cut& cut : cuts) {
    const HalfSpace proximal{cut.normal, cut.normal.dot(cut.point)};
    if (cut.proximal == part) spaces.push_back(proximal);
    if (cut.distal == part) spaces.push_back(proximal.other_side());
  }
  return spaces;
}

Result<BodyPlan> plan_body(const PhantomOptions& options, double build) {
  const auto angles = all_angles(options, build);
  if (!angles) return tl::unexpected(angles.error());
  BodyPlan plan;
  plan.size = proportions(options);
  plan.size.bone *= std::clamp(std::sqrt(build), 0.85, 1.0);
  plan.size.arm_bone *= plan.size.bone;
  plan.size.leg_bone *= plan.size.bone;
  plan.crosses_shoulders = build > 1.27;
  for (const std::string_view side : side_name) {
    const double abduction = angles->at(fmt::format("shoulder_{}_abduction", side));
    plan.crosses_shoulders = plan.crosses_shoulders || abduction < 8 || abduction > 60;
  }
  place_levels(plan);
  // both sides are built like the left one; the right one's frames are mirrored
  const std::array<Frame, 2> half{Frame{},
                                  Frame{Vector3d(-1, 1, 1).asDiagonal().toDenseMatrix(), Vector3d::Zero()}};
  for (const int side : {left_side, right_side}) {
    place_leg(plan, side, half[static_cast<std::size_t>(side)], *angles);
    place_arm(plan, side, half[static_cast<std::size_t>(side)], *angles);
  }
  plan.hip = plan.thigh[0].origin.z();
  plan.asis = plan.hip + plan.size.asis_up;
  mark_trunk(plan);
  for (const int side : {left_side, right_side}) mark_limbs(plan, side, half[static_cast<std::size_t>(side)]);
  plan.cuts = cut_planes(plan.landmarks);
  return plan;
}

}  // namespace borelli
