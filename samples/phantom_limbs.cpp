// The phantom's limb bones. Long bones end at the joints with a gap of a few millimetres; articulating ends
// are spheres (shoulder, hip) or cylinders on the joint's axis (elbow, knee, ankle).
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>

#include "samples/phantom_builder.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

// All shapes are given in their limb's frame (see phantom_plan.hpp), in mm for a bone of usual thickness: `w`
// scales dimensions across the limb.
struct LimbBones {
  PhantomBuilder& builder;
  const Frame& frame;
  std::vector<int> hosts;
  std::string at;  // " left" or " right"
  double w;

  std::vector<int> put(const std::string& name, const EllipticStack& shape, double cortex) const {
    return builder.bone(name + at, shape.moved(frame), cortex, hosts);
  }
  void mark(const std::string& name, const Vector3d& point) const {
    builder.mark(name + "_" + at.substr(1), frame.point(point));
  }
};

std::vector<Section> across(double w, std::vector<Section> sections) {
  for (Section& s : sections) s = {s.height, s.x * w, s.y * w, s.a * w, s.b * w, s.inset};
  return sections;
}

EllipticStack cylinder(const Vector3d& from, const Vector3d& to, double radius) {
  return cone(from, to, Vector2d::Constant(radius), Vector2d::Constant(radius), Vector3d::UnitZ());
}

void add_humerus(const LimbBones& limb, double length) {
  const double w = limb.w, l = length;
  const Vector3d neck = Vector3d(1, 0, -1).normalized();
  const Vector3d seam = 12 * w * neck;
  limb.put("humeral head",
           ellipsoid(Vector3d::Zero(), Vector3d::Constant(humeral_head * w)).cut(below(neck, seam)), 2);
  const double epicondyles = -l + 9 * w;
  limb.put("humerus",
           EllipticStack(Frame{},
                         across(w, {{epicondyles, 0, 0, 27, 8},
                                    {-l + 30, 0, 0, 21, 9},
                                    {-l + 65, 1, 0, 11.5, 10.5},
                                    {-0.4 * l, 4, 0, 11, 11},
                                    {-60, 8, 0, 12, 12},
                                    {-22, 9, 0, 17, 18},
                                    {15, 8, 0, 17, 18}}),
                         0, 12)
               .cut(above(neck, seam)),
           3);
  const Vector3d elbow(0, 0, -l), half(30 * w, 0, 0);
  limb.put(
      "humeral condyles",
      cylinder(elbow - half, elbow + half, trochlea * w).cut(below(Vector3d::UnitZ(), {0, 0, epicondyles})),
      1.5);
}

void add_forearm_bones(const LimbBones& limb, double length) {
  const double w = limb.w, l = length;
  limb.put("ulna",
           EllipticStack(Frame{},
                         across(w, {{-l + 5, -1, 14, 6, 6},
                                    {-l + 30, -1, 13, 5.5, 6},
                                    {-0.6 * l, -5, 10, 6, 7},
                                    {-50, -6, 11, 7.5, 8.5},
                                    {-24, -5, 18, 9, 8},
                                    {10, -3, 20.5, 9, 6.5}}),
                         4, 6),
           2);
  limb.put("radius",
           EllipticStack(Frame{}, across(w, {{-l + 6, 1, -8, 10, 13},
                                             {-l + 22, 1, -8, 9, 12},
                                             {-l + 50, 3, -7, 7, 8},
                                             {-0.5 * l, 9, -6, 7, 7},
                                             {-45, 12, -2, 7.5, 7.5},
                                             {-24, 13, 0, 8, 8},
                                             {-14, 13, 0, 10, 10}})),
           2);
  limb.mark("ulnar_styloid", {-1 * w, 14 * w, -l + 5});
  limb.mark("radial_styloid",
            {1 * w, -21 * w, -l + 6});  // its end is flat: the rim point farthest from the ulna
}

void add_hand_bones(const LimbBones& palm, const PhantomBuilder& builder, const Flesh& flesh,
                    std::size_t side) {
  const Proportions& p = builder.plan.size;
  const double h = p.hand / 187.9, w = palm.w;
  for (int row = 0; row < 2; ++row)
    for (int k = 0; k < 4; ++k)
      palm.put(fmt::format("carpal {}", 4 * row + k + 1),
               ellipsoid({0, (-14.3 + 9.6 * k) * w, -(9 + 12.5 * row) * h}, {6.5 * w, 4.7 * w, 5.8 * h}),
               1.5);
  const auto all = fingers(p);
  for (std::size_t k = 1; k < 5; ++k) {
    const double y = (-13.0 + 9.0 * static_cast<double>(k - 1)) * w;
    palm.put(fmt::format("metacarpal {}", k + 1),
             capsule({0, y, -34 * h}, {0, all[k].base.y() + 1, -86 * h}, 4.1 * w), 1.8);
  }
  palm.put("metacarpal 1",
           capsule({0, -24 * p.hand_flesh, -36 * h}, {0, -33 * p.hand_flesh, -52 * h}, 4.5 * w), 1.8);
  for (std::size_t k = 0; k < 5; ++k) {
    const Finger& finger = all[k];
    const LimbBones inside{palm.builder, palm.frame, {flesh.finger[side][k]}, palm.at, w};
    const std::array<double, 4> ends =
        k == 0 ? std::array<double, 4>{0.06, 0.5, 0.9, 0.9} : std::array<double, 4>{0.03, 0.46, 0.74, 0.93};
    for (std::size_t j = 0; j < (k == 0 ? 2 : 3); ++j) {
      const double r = (k == 0 ? 4.2 : 3.7 - 0.4 * static_cast<double>(j)) * w;
      const Vector3d from = finger.base + finger.direction * (ends[j] * finger.length + r);
      const Vector3d to = finger.base + finger.direction * (ends[j + 1] * finger.length - r - 1.5);
      inside.put(fmt::format("phalanx {}.{}", k + 1, j + 1), capsule(from, to, r), 1.4);
    }
  }
}

void add_femur(const LimbBones& limb, double length, bool metal) {
  const double w = limb.w, l = length;
  const Vector3d neck = Vector3d(0.82, 0.05, -0.57).normalized();
  const Vector3d head_seam = 15 * w * neck, shaft_seam = 40 * w * neck, up = Vector3d::UnitZ();
  const auto upper = [&](const std::string& name, const EllipticStack& shape, double cortex) {
    if (metal)
      limb.builder.nest(name + limb.at, shape.moved(limb.frame), tissue::metal, limb.hosts);
    else
      limb.put(name, shape, cortex);
  };
  upper("femoral head",
        ellipsoid(Vector3d::Zero(), Vector3d::Constant(femoral_head * w)).cut(below(neck, head_seam)), 1.5);
  upper("femoral neck", cone(head_seam, shaft_seam, Vector2d(14, 15) * w, Vector2d(15, 18) * w), 2);
  const double seam = -l + 12 * w;
  limb.put("femur",
           EllipticStack(Frame{},
                         across(w, {{seam, 0, 0, 38, 19},
                                    {-l + 40, 1, 0, 31, 20},
                                    {-l + 85, 5, -1, 17, 15},
                                    {-0.6 * l, 19, -3, 13.5, 13.5},
                                    {-150, 30, -3, 13.5, 13.5},
                                    {-80, 41, 0, 15, 15},
                                    {-42, 49, 2, 18, 19},
                                    {-6, 51, 4, 15, 18}}),
                         0, 12)
               .cut(above(neck, shaft_seam)),
           5);
  for (const double sign : {-1.0, 1.0})
    limb.put(sign < 0 ? "medial condyle" : "lateral condyle",
             cylinder({sign * 7 * w, 0, -l}, {sign * 40 * w, 0, -l}, knee_condyle * w)
                 .cut(below(up, {0, 0, seam})),
             1.5);
  limb.put("patella", ellipsoid({0, -35 * w, -l + 8}, {20 * w, 7 * w, 20 * w}), 2);
}

void add_shank_bones(const LimbBones& limb, double length) {
  const double w = limb.w, l = length, plafond = -l + 16 * w;
  limb.put("tibia",
           EllipticStack(Frame{}, across(w, {{plafond, -1, 1, 19, 17},
                                             {-l + 28, -1, 1, 18, 17},
                                             {-l + 60, -1, 0, 12, 12},
                                             {-0.6 * l, -1, -3, 11, 12},
                                             {-150, -2, -4, 12, 14},
                                             {-80, -2, -1, 17, 18},
                                             {-45, 0, 2, 33, 23},
                                             {-27 * w, 0, 3, 37, 24}})),
           3.5);
  limb.put("medial malleolus",
           capsule({-26 * w, 0, -l + 22}, {-26 * w, 0, -l - w}, 5 * w)
               .cut(below(Vector3d::UnitZ(), {0, 0, plafond})),
           1.5);
  limb.put("fibula",
           EllipticStack(Frame{},
                         across(w, {{-l - 14 * w, 25.5, 6, 4.6, 7.2},
                                    {-l + 10, 25.5, 6, 4.6, 7.2},
                                    {-l + 50, 23.5, 8, 5, 6},
                                    {-0.5 * l, 26, 16, 6, 6},
                                    {-78, 31, 18, 6, 6},
                                    {-42, 34, 20, 7.5, 8.5}}),
                         8, 8),
           1.8);
}

void add_foot_bones(const LimbBones& limb, double ankle, double length) {
  const double w = limb.w, f = length / 258.1, v = ankle / 64;
  const Vector3d back = Vector3d::UnitY();
  limb.put("talus",
           cylinder({-17 * w, 0, 0}, {17.5 * w, 0, 0}, talar_dome * w).cut(above(back, {0, -9 * w, 0})), 1.5);
  limb.put("talar head",
           cone({-2, -9 * w, -4 * v}, {-7, -36 * f, -16 * v}, Vector2d(12, 8) * w, Vector2d(11, 9) * w)
               .cut(below(back, {0, -9 * w, 0})),
           1.5);
  // the stack lies along the foot: heights run from heel to toe
  Matrix3d along;
  along << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Frame foot{along, Vector3d::Zero()};
  limb.put("calcaneus",
           EllipticStack(foot,
                         {{-43 * f, 0, -38 * v, 12 * w, 17 * v},
                          {-15 * f, 0, -37 * v, 14 * w, 18 * v},
                          {5 * f, 2, -34 * v, 14 * w, 15 * v},
                          {31 * f, 9, -36 * v, 11 * w, 11 * v}},
                         12 * f, 4 * f),
           1.5);
  limb.put("navicular", ellipsoid({-10 * w, -46 * f, -22 * v}, {14 * w, 5.5 * f, 11 * v}), 1.5);
  limb.put("cuboid", ellipsoid({15 * w, -48 * f, -38 * v}, {10 * w, 14 * f, 10 * v}), 1.5);
  for (int k = 0; k < 3; ++k)
    limb.put(fmt::format("cuneiform {}", k + 1),
             ellipsoid({(-21 + 11.5 * k) * w, -62 * f, (-28 - 2 * k) * v}, {5.3 * w, 8.5 * f, 9 * v}), 1.5);
  for (int k = 0; k < 5; ++k) {
    const double thick = k == 0 ? 6.5 : 4.6, x0 = (k == 0 ? -24 : -22) + 10.6 * k, x1 = -30 + 14.2 * k;
    const Vector3d base(x0 * w, (k < 3 ? -79 : -70) * f, (-32 - 2.5 * k) * v);
    const Vector3d head(x1 * w, (-142 + 4 * k) * f, -52 * v);
    limb.put(fmt::format("metatarsal {}", k + 1), capsule(base, head, thick * w), 1.5);
    if (k == 0 || k == 1 || k == 4) limb.mark(fmt::format("metatarsal_{}", k + 1), head);
    const double toe = (-189 + 5 * k) * f;
    limb.put(fmt::format("toe {}", k + 1),
             capsule({x1 * w, head.y() - (2 * thick + 2) * w, -53 * v}, {(x1 + 0.5) * w, toe, -54 * v},
                     (k == 0 ? 4.6 : 3.6) * w),
             1.4);
  }
}

}  // namespace

void add_arm_bones(PhantomBuilder& builder, const Flesh& flesh, int side) {
  const std::size_t s = static_cast<std::size_t>(side);
  const BodyPlan& plan = builder.plan;
  const std::string at = fmt::format(" {}", side_name[s]);
  const double w = plan.size.arm_bone;
  add_humerus(
      {builder, plan.upper_arm[s], {flesh.upper_arm[s], flesh.upper_arm_low[s], flesh.forearm[s]}, at, w},
      plan.size.upper_arm);
  add_forearm_bones(
      {builder, plan.forearm[s], {flesh.forearm[s], flesh.upper_arm[s], flesh.upper_arm_low[s]}, at, w},
      plan.size.forearm);
  add_hand_bones({builder, plan.hand[s], {flesh.palm[s], flesh.forearm[s]}, at, w}, builder, flesh, s);
}

void add_leg_bones(PhantomBuilder& builder, const Flesh& flesh, int side) {
  const std::size_t s = static_cast<std::size_t>(side);
  const BodyPlan& plan = builder.plan;
  const std::string at = fmt::format(" {}", side_name[s]);
  const double w = plan.size.leg_bone;
  add_femur(
      {builder, plan.thigh[s], {flesh.thigh[s], flesh.flank[s], flesh.shank[s], flesh.lower_trunk}, at, w},
      plan.size.thigh, builder.metal_hip == side_name[s]);
  add_shank_bones({builder, plan.shank[s], {flesh.shank[s], flesh.thigh[s], flesh.foot[s]}, at, w},
                  plan.size.shank);
  add_foot_bones({builder, plan.foot[s], {flesh.foot[s], flesh.shank[s]}, at, w}, plan.size.ankle,
                 plan.size.foot);
}

}  // namespace borelli
