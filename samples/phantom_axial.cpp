// Contents of the phantom's trunk and head: organs, skull, spine, rib cage, shoulder girdle, pelvis.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "samples/phantom_builder.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

std::vector<int> trunk_and_head(const Flesh& flesh) {
  return {flesh.head, flesh.upper_trunk, flesh.upper_trunk_low, flesh.middle_trunk, flesh.lower_trunk};
}

// The thoracic cage's outer wall, in which the ribs lie.
EllipticStack cage_wall(const BodyPlan& plan) {
  const double n = plan.neck, x = plan.xiphion, rise = (n - x) / 237.6, w = plan.size.bone;
  const auto at = [&](double height, double y, double a, double b) -> Section {
    return {height, 0, y * w, a * w, b * w};
  };
  return EllipticStack(
      Frame{}, {at(x - 110, -8, 110, 74), at(x - 60, -8, 121, 81), at(x, -7, 127, 88),
                at(n - 200 * rise, -5, 127, 90), at(n - 150 * rise, -3, 123, 86),
                at(n - 100 * rise, 0, 110, 78), at(n - 60 * rise, 4, 88, 63), at(n - 6 * rise, 10, 42, 30)});
}
constexpr double rib_depth = 9;

void add_skull(PhantomBuilder& builder, const Flesh& flesh) {
  const double n = builder.plan.neck, r = builder.plan.size.head / 238.4, w = builder.plan.size.head_flesh;
  const Vector3d up = Vector3d::UnitZ();
  const EllipticStack cranium = ellipsoid({0, -20 * w, n + 161 * r}, {68 * w, 88 * w, 67 * r});
  const auto bone =
      builder.nest("skull", cranium.cut(above(up, {0, 0, n + 109 * r})), tissue::cortex, {flesh.head});
  builder.nest("brain", cranium.shrunk(6).cut(above(up, {0, 0, n + 116 * r})), tissue::brain, bone);
  builder.bone(
      "maxilla",
      ellipsoid({0, -66 * w, n + 104 * r}, {32 * w, 22 * w, 15 * r}).cut(below(up, {0, 0, n + 108 * r})), 2,
      {flesh.head});
  const double jaw = n + 73 * r;
  const auto arch = [&](double a, double b, double low, double high) {
    return cone({0, -36 * w, jaw + low}, {0, -38 * w, jaw + high}, {a * w, b * w}, {(a + 2) * w, (b + 3) * w})
        .cut(below(Vector3d::UnitY(), {0, -22, 0}));
  };
  builder.nest("mandible", arch(40, 38, 0, 14 * r).hollowed(arch(31, 29, 0, 14 * r)), tissue::cortex,
               {flesh.head});
}

// y of the vertebral bodies' midline at a height.
double spine_line(const BodyPlan& plan, double height) {
  const double n = plan.neck, x = plan.xiphion, o = plan.omphalion, w = plan.size.bone;
  const EllipticStack line(Frame{}, {{o - 60, 0, 30 * w, 1, 1},
                                     {o, 0, plan.landmarks.at("spine_lower").point.y(), 1, 1},
                                     {x - 90, 0, 25 * w, 1, 1},
                                     {x, 0, plan.landmarks.at("spine_upper").point.y(), 1, 1},
                                     {n - 140, 0, 37 * w, 1, 1},
                                     {n - 55, 0, 21 * w, 1, 1},
                                     {n, 0, 0, 1, 1},
                                     {n + 60, 0, -9 * w, 1, 1},
                                     {n + 120, 0, -10 * w, 1, 1}});
  return line.section(height).y;
}

struct Vertebra {
  const char* name;
  double low, high;      // middles of the discs below and above
  double a, b;           // semi-axes of the body
  double lamina, slant;  // half breadth over the transverse processes; descent of the spinous process
  double disc_low = 0, disc_high = 0;  // half the thickness of those discs
};

std::vector<Vertebra> vertebrae(const BodyPlan& plan) {
  const double n = plan.neck, x = plan.xiphion, o = plan.omphalion, w = plan.size.bone;
  std::vector<Vertebra> spine;
  // heights are proportional within a stretch of the spine between given ends, from its top down
  const auto stretch = [&](double top, double bottom, std::initializer_list<const char*> names,
                           std::initializer_list<double> heights, Vector2d upper, Vector2d lower,
                           double lamina, double slant) {
    double sum = 0, at = top, placed = 0;
    for (const double h : heights) sum += h;
    auto h = heights.begin();
    for (const char* name : names) {
      const double low = at - *h++ / sum * (top - bottom);
      const Vector2d semi = w * (upper + placed / static_cast<double>(names.size()) * (lower - upper));
      spine.push_back({name, low, at, semi.x(), semi.y(), lamina * w, slant * w});
      at = low, placed += 1;
    }
  };
  const double r = plan.size.head / 238.4;
  stretch(n + 105 * r, n, {"C1", "C2", "C3", "C4", "C5", "C6", "C7"}, {15, 17, 14, 14, 14, 15, 16}, {10, 8},
          {13, 9}, 22, 4);
  stretch(n, x, {"T1", "T2", "T3", "T4", "T5", "T6", "T7", "T8", "T9", "T10"},
          {21, 22, 22, 23, 23, 24, 24, 25, 26, 27}, {14, 10}, {17, 14}, 27, 12);
  stretch(x, o, {"T11", "T12", "L1", "L2", "L3", "L4"}, {30, 32, 35, 37, 38, 38}, {19, 14}, {23, 16}, 30, 4);
  stretch(o, o - 40, {"L5"}, {1}, {24, 16}, {24, 16}, 32, 3);
  for (std::size_t i = 0; i < spine.size(); ++i) {
    const double own = spine[i].high - spine[i].low;
    const double above = i > 0 ? spine[i - 1].high - spine[i - 1].low : own;
    spine[i].disc_high = 0.05 * (own + above);
    if (i > 0) spine[i - 1].disc_low = spine[i].disc_high;
  }
  spine.back().disc_low = spine.back().disc_high;
  return spine;
}

void add_vertebra(PhantomBuilder& builder, const Flesh& flesh, const Vertebra& v) {
  const std::vector<int> hosts = trunk_and_head(flesh);
  const BodyPlan& plan = builder.plan;
  const double middle = 0.5 * (v.low + v.high), w = plan.size.bone;
  // planes that separate body, pedicles, lamina and spinous process, from front to back
  const double back = spine_line(plan, middle) + 0.8 * v.b, arch = back + 9 * w, rear = arch + 8 * w;
  const auto before = [&](double plane) { return below(Vector3d::UnitY(), {0, plane, 0}); };
  const auto behind = [&](double plane) { return above(Vector3d::UnitY(), {0, plane, 0}); };
  const std::string name = v.name;
  const auto pile = [&](double from, double to) {
    return EllipticStack(Frame{}, {{from, 0, spine_line(plan, from), v.a, v.b},
                                   {to, 0, spine_line(plan, to), v.a, v.b}})
        .cut(before(back));
  };
  builder.bone(name, pile(v.low + v.disc_low, v.high - v.disc_high), 1.5, hosts);
  builder.nest(name + " disc below", pile(v.low - v.disc_low, v.low + v.disc_low), tissue::cartilage, hosts);
  const double size = std::min(1.0, (v.high - v.low) / 22);
  for (const double sign : {-1.0, 1.0})
    builder.nest(name + " pedicle",
                 cone({sign * 0.7 * v.a, back, middle + 2}, {sign * 0.7 * v.a, arch, middle + 2},
                      Vector2d(4, 5) * size * w, Vector2d(4, 5) * size * w),
                 tissue::cortex, hosts);
  builder.nest(name + " lamina",
               ellipsoid({0, 0.5 * (arch + rear), middle}, {v.lamina, 7 * w, 7.5 * size * w})
                   .cut(behind(arch))
                   .cut(before(rear)),
               tissue::cortex, hosts);
  // the spinous process extends towards the skin of the back; C7's ends at the cervicale
  Vector3d tip(0, rear + 20 * w, middle - v.slant);
  for (const int host : hosts) {
    if (host < 0) continue;
    const EllipticStack& muscle = builder.solids[static_cast<std::size_t>(host)].shape;
    if (tip.z() < muscle.low() || tip.z() > muscle.high()) continue;
    const Ellipse e = muscle.section(tip.z());
    tip.y() = std::min(tip.y(), e.y + e.b - 6);
    break;
  }
  if (name == "C7") tip = plan.landmarks.at("cervicale").point;
  if (name == "T8") builder.mark("t8", tip);
  const Vector3d root(0, rear - 3, middle);
  if (tip.y() > rear + 2)
    builder.nest(name + " spinous process",
                 cone(root, tip, Vector2d(3.5, 6 * size) * w, Vector2d(2.5, 4 * size) * w).cut(behind(rear)),
                 tissue::cortex, hosts);
}

void add_ribs(PhantomBuilder& builder, const Flesh& flesh, const std::vector<Vertebra>& spine) {
  const BodyPlan& plan = builder.plan;
  const EllipticStack wall = cage_wall(plan);
  const std::vector<int> hosts{flesh.upper_trunk, flesh.upper_trunk_low, flesh.middle_trunk};
  const double tilt = 22 * std::numbers::pi / 180;
  const Vector3d normal(0, -std::sin(tilt), std::cos(tilt));  // a rib descends from back to front
  for (int k = 1; k <= 12; ++k) {
    const Vertebra& v = spine[static_cast<std::size_t>(6 + k)];
    const double level = std::min(0.5 * (v.low + v.high), wall.high() - 4);
    const Ellipse e = wall.section(std::max(level, wall.low()));
    const Vector3d head(0, e.y + e.b, level);
    const double end = k <= 10 ? e.y - 0.55 * e.b : e.y + (k == 11 ? 0.2 : 0.5) * e.b;
    const double lateral = k == 1 || k >= 9 ? 28 : 22;  // clear of the transverse processes
    const auto ring = [&](double outside, double inside, double half, double middle, double sign) {
      return wall.shrunk(outside)
          .hollowed(wall.shrunk(inside))
          .cut(below(normal, head + half * normal))
          .cut(above(normal, head - half * normal))
          .cut(above(Vector3d(sign, 0, 0), Vector3d(sign * middle, 0, 0)));
    };
    for (const double sign : {1.0, -1.0}) {
      const std::string name = fmt::format("rib {} {}", k, sign > 0 ? "left" : "right");
      const HalfSpace bony = above(Vector3d::UnitY(), {0, end, 0});
      const auto made =
          builder.nest(name, ring(0, rib_depth, 5.5, lateral, sign).cut(bony), tissue::cortex, hosts);
      builder.nest(name + " spongiosa", ring(2, rib_depth - 2, 3.5, lateral + 2, sign).cut(bony),
                   tissue::spongiosa, made);
      if (k >= 3 && k <= 7)
        builder.nest(name + " cartilage", ring(1, rib_depth - 1, 4.5, 25, sign).cut(bony.other_side()),
                     tissue::cartilage, hosts);
    }
  }
}

void add_sternum(PhantomBuilder& builder, const Flesh& flesh) {
  const Vector3d top = builder.plan.landmarks.at("suprasternale").point;
  const Vector3d tip = builder.plan.landmarks.at("xiphion").point;
  const double length = (top - tip).norm(), w = builder.plan.size.bone;
  const Frame frame{axes_along(top - tip, Vector3d::UnitX()), tip};
  builder.bone("sternum",
               EllipticStack(frame,
                             {{0, 0, 0, 6 * w, 3.5 * w},
                              {0.12 * length, 0, 0, 8 * w, 4 * w},
                              {0.3 * length, 0, 0, 18 * w, 5.5 * w},
                              {0.7 * length, 0, 0, 15 * w, 5.5 * w},
                              {length, 0, 0, 21 * w, 6 * w}},
                             8, 0),
               1.2, {flesh.upper_trunk, flesh.upper_trunk_low, flesh.middle_trunk});
}

void add_shoulder_girdle(PhantomBuilder& builder, const Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const std::size_t s = static_cast<std::size_t>(side);
  const double sign = side == left_side ? 1 : -1, n = plan.neck, w = plan.size.bone;
  const Frame half{Vector3d(sign, 1, 1).asDiagonal().toDenseMatrix(), Vector3d::Zero()};
  const Vector3d shoulder(plan.size.shoulder_half, 2, n - 88);  // as in the standing pose
  const std::string at = fmt::format(" {}", side_name[s]);
  const std::vector<int> hosts{flesh.upper_trunk, flesh.upper_trunk_low, flesh.upper_arm[s]};
  builder.bone("clavicle" + at,
               capsule({31, -55, n - 65}, shoulder + Vector3d(-34 * w, -8, 24 * w), 6 * w).moved(half), 2,
               hosts);
  builder.nest("acromion" + at,
               ellipsoid(shoulder + Vector3d(2, 4, 33 * w), {19 * w, 12 * w, 5 * w}).moved(half),
               tissue::cortex, hosts);
  builder.nest("glenoid" + at,
               ellipsoid(shoulder + Vector3d(-(humeral_head * plan.size.arm_bone + 8.5 * w), 5, -2),
                         {6 * w, 11 * w, 16 * w})
                   .moved(half),
               tissue::cortex, hosts);
  Matrix3d plate;
  const Vector3d outwards = Vector3d(0.82, -0.57, 0).normalized();
  plate << outwards, outwards.cross(Vector3d::UnitZ()), Vector3d::UnitZ();
  // a left-handed frame would give the mirrored plate, which is the same plate
  builder.nest(
      "scapula" + at,
      ellipsoid(shoulder + Vector3d(-70 * w, 37 * w, -28), {43 * w, 3.5 * w, 53 * w}, plate).moved(half),
      tissue::cortex, hosts);
}

void add_pelvis(PhantomBuilder& builder, const Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const std::size_t s = static_cast<std::size_t>(side);
  const double sign = side == left_side ? 1 : -1, w = plan.size.bone;
  const Frame half{Vector3d(sign, 1, 1).asDiagonal().toDenseMatrix(), Vector3d::Zero()};
  const std::string at = fmt::format(" {}", side_name[s]);
  const std::vector<int> hosts{flesh.lower_trunk, flesh.flank[s], flesh.thigh[s]};
  const auto put = [&](const char* name, const EllipticStack& shape, double cortex) {
    builder.bone(name + at, shape.moved(half), cortex, hosts);
  };
  const Vector3d up = Vector3d::UnitZ(), back = Vector3d::UnitY();
  const Vector3d spine_tip(plan.size.asis_half, -50 * w, plan.asis);
  const Vector3d hip(plan.size.hip_half, 0, plan.hip);

  // iliac wing, from the spine tip to the sacrum
  const Vector3d along = Vector3d(-0.5, 0.866, 0).normalized();
  Matrix3d plate;
  plate << along.cross(up), along, up;
  const double low = plan.hip + 28, high = plan.asis + 44;
  const Vector3d wing(plan.size.asis_half - 26 * w, 0, low + 0.363 * (high - low));
  const Vector3d semi_axes(7 * w, 66 * w, 0.637 * (high - low));
  put("ilium",
      ellipsoid(wing, semi_axes, plate).cut(above(up, hip + 28 * up)).cut(above(back, {0, -39 * w, 0})), 2);
  // the posterior superior iliac spine is the wing's hindmost point
  const Vector3d backwards = semi_axes.cwiseProduct(plate.transpose() * back).normalized();
  builder.mark(fmt::format("psis_{}", side_name[s]),
               half.point(wing + plate * semi_axes.cwiseProduct(backwards)));

  // the anterior superior iliac spine is the bone's foremost point
  put("asis",
      ellipsoid(spine_tip + Vector3d(0, 13 * w, 0), {7 * w, 13 * w, 9 * w}).cut(below(back, {0, -39 * w, 0})),
      2);

  // socket about the femoral head, open to the side, forwards and down
  const Vector3d tuber(62, 28 * w, plan.hip - 74 * w), symphysis(8, -36 * w, plan.hip - 12);
  const Vector3d ischium = (tuber - hip).normalized(), pubis = (symphysis - hip).normalized();
  const double inner = femoral_head * plan.size.leg_bone + 3.5, outer = inner + 6, foot = inner + 2;
  const Vector3d opening = Vector3d(0.75, -0.3, -0.55).normalized();
  const auto socket = [&](double radius) { return ellipsoid(hip, Vector3d::Constant(radius)); };
  builder.nest("acetabulum" + at,
               socket(outer)
                   .hollowed(socket(inner))
                   .cut(below(opening, hip + 4 * opening))
                   .cut(below(up, hip + 28 * up))
                   .cut(below(ischium, hip + foot * ischium))
                   .cut(below(pubis, hip + foot * pubis))
                   .moved(half),
               builder.metal_hip == side_name[s] ? tissue::metal : tissue::cortex, hosts);
  put("ischium", cone(hip + foot * ischium, tuber, {12 * w, 13 * w}, {14 * w, 17 * w}), 2);
  put("pubis",
      cone(hip + foot * pubis, symphysis, {10 * w, 9 * w}, {9 * w, 9 * w})
          .cut(above(Vector3d::UnitX(), {2, 0, 0})),
      2);
  put("ramus", capsule({34, -19 * w, plan.hip - 36}, {47, 6, plan.hip - 70 * w}, 5.5 * w), 2);
}

void add_sacrum(PhantomBuilder& builder, const Flesh& flesh) {
  const double o = builder.plan.omphalion, w = builder.plan.size.bone;
  const double top = o - 45, low = builder.plan.hip - 12;
  const double length = top - low;
  builder.bone("sacrum",
               EllipticStack(Frame{},
                             {{low, 0, 52 * w, 7 * w, 5 * w},
                              {low + 0.25 * length, 0, 62 * w, 20 * w, 8 * w},
                              {low + 0.6 * length, 0, 52 * w, 38 * w, 14 * w},
                              {top, 0, 28 * w, 46 * w, 17 * w}},
                             6, 0),
               2, {flesh.lower_trunk, flesh.middle_trunk});
}

}  // namespace

void add_organs(PhantomBuilder& builder, const Flesh& flesh) {
  const BodyPlan& plan = builder.plan;
  const double n = plan.neck, x = plan.xiphion, rise = (n - x) / 237.6, w = plan.size.bone;
  const std::vector<int> hosts{flesh.upper_trunk, flesh.upper_trunk_low, flesh.middle_trunk};
  const auto at = [&](double height, double across, double y, double a, double b) -> Section {
    return {height, across * w, y * w, 0.955 * a * w, 0.955 * b * w};
  };
  for (const double sign : {1.0, -1.0}) {
    const EllipticStack lung(Frame{},
                             {at(x - 28, 64, -4, 44, 58), at(x + 20, 64, -4, 45, 62),
                              at(n - 180 * rise, 62, -3, 45, 62), at(n - 125 * rise, 56, -1, 39, 56),
                              at(n - 80 * rise, 50, 2, 31, 44), at(n - 38 * rise, 42, 6, 26, 34)},
                             60, 34);
    const Frame half{Vector3d(sign, 1, 1).asDiagonal().toDenseMatrix(), Vector3d::Zero()};
    builder.nest(sign > 0 ? "lung left" : "lung right", lung.moved(half), tissue::lung, hosts);
  }
  builder.nest("heart", ellipsoid({0, -38 * w, x + 50}, {18 * w, 28 * w, 45}), tissue::blood, hosts);
  builder.nest("liver", ellipsoid({-46 * w, -20 * w, x - 76}, {48 * w, 44 * w, 44}), tissue::liver, hosts);
  builder.nest("trachea", capsule({0, -42 * w, n + 50}, {0, -26 * w, n - 50}, 8), tissue::air,
               {flesh.head, flesh.upper_trunk, flesh.upper_trunk_low});
}

void add_axial_bones(PhantomBuilder& builder, const Flesh& flesh) {
  add_skull(builder, flesh);
  const std::vector<Vertebra> spine = vertebrae(builder.plan);
  for (const Vertebra& v : spine) add_vertebra(builder, flesh, v);
  add_ribs(builder, flesh, spine);
  add_sternum(builder, flesh);
  add_sacrum(builder, flesh);
  for (const int side : {left_side, right_side}) {
    add_shoulder_girdle(builder, flesh, side);
    add_pelvis(builder, flesh, side);
  }
}

}  // namespace borelli
