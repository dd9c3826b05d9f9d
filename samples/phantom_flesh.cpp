// The phantom's outer shape: fat under the skin and muscle within, for every segment; and the navel.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "samples/phantom_builder.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;
using Sections = std::vector<Section>;

// Thickness of fat at a cross-section `semi` mm wide, girth included. Girth above 1 adds half fat, half
// muscle; girth below 1 thins the fat first.
double fat_depth(double usual, double semi, double girth) {
  return girth > 1 ? usual + 0.5 * (1 - 1 / girth) * semi : usual * std::max(0.5, 1 - 6 * (1 - girth));
}

Sections thickened(Sections sections, double size, double girth, double fat) {
  for (Section& s : sections) {
    s.a *= size * girth;
    s.b *= size * girth;
    s.inset = fat_depth(s.inset * fat, std::min(s.a, s.b), girth);
  }
  return sections;
}

struct Ends {
  double low = 0, high = 0;  // length of the rounded ends
};

// Adds fat with muscle within; returns the muscle's index. The sections' inset is the fat's thickness.
int add_limb(PhantomBuilder& builder, const std::string& name, int part, const Frame& frame,
             const Sections& sections, Ends ends, const std::vector<HalfSpace>& cuts,
             const std::vector<HalfSpace>& muscle_cuts = {}) {
  Sections skin = sections;
  for (Section& s : skin) s.inset = 0;
  const double tip = std::max(sections.front().inset, sections.back().inset);
  const int fat = builder.add(name + " fat", EllipticStack(frame, skin, ends.low, ends.high).cut(cuts),
                              tissue::fat, part);
  const auto muscle = builder.nest(name + " muscle",
                                   EllipticStack(frame, sections, ends.low, ends.high, tip).cut(muscle_cuts),
                                   tissue::muscle, {fat});
  return muscle.front();
}

// add_limb adds the fat just before its muscle.
int fat_of(int muscle) { return muscle - 1; }

Section at_height(Section section, double height) {
  section.height = height;
  return section;
}

// The limb's side of the midsagittal plane: thick thighs meet there.
HalfSpace own_half(int side) { return {Vector3d(side == left_side ? -1 : 1, 0, 0), 0}; }

// Heads, hands and feet vary less with girth than trunk and limbs.
double lesser(double girth) { return 1 + 0.3 * (girth - 1); }

// Below this plane the thigh belongs to the leg; above it, it continues the trunk's shape.
HalfSpace flank_seat(const BodyPlan& plan) { return {Vector3d::UnitZ(), plan.hip + 40}; }

// Distance from the shoulder within which its plane acts (cuts.hpp: a ball of three radii of the humeral
// head). Here it is the mean height of that ball's edge over the arm's breadth, for a flat end.
double shoulder_reach(const BodyPlan& plan) { return 0.92 * 3 * humeral_head * plan.size.arm_bone; }
double shoulder_floor(const BodyPlan& plan) { return plan.upper_arm[0].origin.z() - shoulder_reach(plan); }

// The height at which the hips' cuts meet; no trunk lies below it.
double crotch(const BodyPlan& plan) {
  for (const Cut& cut : plan.cuts)
    if (cut.joint == "hip_left") return cut.normal.dot(cut.point) / cut.normal.z();
  return plan.hip;
}

// Sections of the trunk: depth before and behind the midline of the fat's outer side at each height.
Sections trunk_sections(const BodyPlan& plan, double girth) {
  const Proportions& p = plan.size;
  const double n = plan.neck, x = plan.xiphion, o = plan.omphalion, g = girth, c = crotch(plan);
  const double chest = p.chest_flesh * g, waist = p.waist_flesh * g, hips = p.pelvis_flesh * g;
  const double shoulders =
      p.chest_flesh * (g > 1 ? g : lesser(g));  // slender bodies are not much narrower there
  const double neck = p.neck_flesh * lesser(g);
  // lengths of trunk parts relative to the usual male's
  const double rise = (n - x) / 237.6, belly = (x - o) / 211.5, low = (o - plan.hip) / 143;
  const auto at = [&](double height, double y, double a, double b, double size, double fat) -> Section {
    return {height,   0,        y * std::sqrt(size),
            a * size, b * size, fat_depth(fat * p.fat, size * std::min(a, b), g)};
  };
  const double deep = p.chest_depth;
  return {at(c - 6, 10, 168, 44, hips, 13),
          at(c + 32, 12, 174, 76, hips, 13),
          at(plan.hip, 10, 171, 106, hips, 13),
          at(plan.hip + 72, -2, 167, 112, 0.5 * (hips + waist), 14),
          at(o - 40 * low, -11, 158, 106, waist, 15),
          at(o, -15, 151, 103, waist, 16),
          at(o + 12 * belly, -15, 150, 102.9, waist, 16),
          at(o + 70 * belly, -13, 146, 104, waist, 14),
          at(o + 140 * belly, -10, 148, 106, 0.5 * (waist + chest), 12),
          at(x, -7, 151, 108, chest, 11),
          at(n - 185 * rise, -9, 154, 111 * deep, chest, 11),
          at(n - 140 * rise, -8, 168, 110 * deep, shoulders, 11),
          at(n - 105 * rise, -4, 178, 102 * deep, shoulders, 11),
          at(n - 78 * rise, -1, 178, 92, shoulders, 10),
          at(n - 56 * rise, -1, 168, 80, shoulders, 9),
          at(n - 40 * rise, -3, 137, 72, 0.5 * (shoulders + neck), 8),
          at(n - 22 * rise, -6, 98, 68, 0.5 * (shoulders + neck), 7),
          at(n, -9, 69, 65, neck, 6),
          at(n + 8, -10, 67, 64, neck, 6)};
}

// Half an ellipsoid of air, its rim on the flat belly; half of it lies in each of the two adjacent parts.
void add_navel(PhantomBuilder& builder, const Flesh& flesh, const HalfSpace& belly_front) {
  const Vector3d rim(0, -belly_front.offset, builder.plan.omphalion);
  builder.plan.landmarks["omphalion"].point = rim;
  for (const int half : builder.nest("navel", ellipsoid(rim, {8, 12, 9}).cut(belly_front), tissue::air,
                                     {fat_of(flesh.middle_trunk), fat_of(flesh.lower_trunk)}))
    builder.solids[static_cast<std::size_t>(half)].part = 0;
}

void add_trunk(PhantomBuilder& builder, Flesh& flesh) {
  const BodyPlan& plan = builder.plan;
  const Sections trunk = trunk_sections(plan, builder.girth);
  // the belly's skin is flat around the navel
  const auto belly = std::find_if(trunk.begin(), trunk.end(),
                                  [&](const Section& section) { return section.height == plan.omphalion; });
  const HalfSpace belly_front{-Vector3d::UnitY(), belly->b - belly->y - 1.2};
  const auto slice = [&](const std::string& name, const std::string& of, std::vector<HalfSpace> cuts) {
    for (const HalfSpace& cut : plan.region(part_label(of))) cuts.push_back(cut);
    return add_limb(builder, name, part_label(of), Frame{}, trunk, {}, cuts);
  };
  if (plan.crosses_shoulders) {
    const HalfSpace floor{Vector3d::UnitZ(), shoulder_floor(plan)};
    flesh.upper_trunk = slice("upper_trunk", "upper_trunk", {floor.other_side()});
    std::vector<HalfSpace> cuts = plan.region(part_label("upper_trunk"));
    std::erase_if(cuts, [](const HalfSpace& cut) { return std::abs(cut.normal.x()) > 0.9; });
    cuts.push_back(floor);
    flesh.upper_trunk_low =
        add_limb(builder, "upper_trunk low", part_label("upper_trunk"), Frame{}, trunk, {}, cuts);
  } else {
    flesh.upper_trunk = slice("upper_trunk", "upper_trunk", {});
  }
  flesh.middle_trunk = slice("middle_trunk", "middle_trunk", {belly_front});
  flesh.lower_trunk = slice("lower_trunk", "lower_trunk", {belly_front});
  for (const int side : {left_side, right_side}) {
    const std::size_t s = static_cast<std::size_t>(side);
    flesh.flank[s] =
        slice(fmt::format("flank_{}", side_name[s]), fmt::format("thigh_{}", side_name[s]),
              {flank_seat(plan).other_side(), {Vector3d::UnitZ(), plan.omphalion}, own_half(side)});
  }
  add_navel(builder, flesh, belly_front);
}

// Ears and nose: ellipsoids cut by the plane tangent to the head at their base.
void add_face(PhantomBuilder& builder, const Flesh& flesh) {
  const double r = builder.plan.size.head / 238.4, w = builder.plan.size.head_flesh;
  const double ear = builder.plan.neck + 140 * r, nose = builder.plan.neck + 126 * r;
  const EllipticStack head = builder.solids[static_cast<std::size_t>(fat_of(flesh.head))].shape;
  const auto slope = [&](double height, auto reach) {
    return reach(head.section(height + 0.5)) - reach(head.section(height - 0.5));
  };
  const auto put = [&](const char* name, const Vector3d& seat, const Vector3d& out, const Vector3d& semi) {
    const HalfSpace outside{-out.normalized(), -out.normalized().dot(seat) - 1e-3};
    builder.add(name, ellipsoid(seat + 2 * out, semi).cut(outside), tissue::muscle, part_label("head"));
  };
  const auto half_width = [](const Ellipse& e) { return e.a; };
  const auto front = [](const Ellipse& e) { return e.b - e.y; };
  const Ellipse at_ear = head.section(ear), at_nose = head.section(nose);
  for (const double sign : {1.0, -1.0})
    put(sign > 0 ? "ear_left" : "ear_right", {sign * at_ear.a, at_ear.y, ear},
        {sign, 0, -slope(ear, half_width)}, {9 * w, 17 * w, 30 * r});
  put("nose", {0, -front(at_nose), nose}, {0, -1, -slope(nose, front)}, {11 * w, 13 * w, 19 * r});
}

void add_head(PhantomBuilder& builder, Flesh& flesh) {
  const BodyPlan& plan = builder.plan;
  const double r = plan.size.head / 238.4, n = plan.neck;
  Sections head{{n - 8, 0, -8, 71, 66, 6},         {n, 0, -9, 69, 65, 6},
                {n + 20 * r, 0, -13, 64, 63, 5},   {n + 50 * r, 0, -17, 61, 62, 5},
                {n + 75 * r, 0, -23, 63, 68, 4},   {n + 95 * r, 0, -28, 69, 78, 4},
                {n + 120 * r, 0, -25, 74, 90, 4},  {n + 150 * r, 0, -21, 78, 97, 4},
                {n + 178 * r, 0, -18, 79, 100, 4}, {n + plan.size.head, 0, -18, 79, 100, 4}};
  const double size = plan.size.head_flesh;
  head = thickened(head, size, lesser(builder.girth), plan.size.fat > 1 ? 1.1 : 1);
  // a child's neck is thin relative to its head
  const double neck = plan.size.neck_flesh / size;
  for (Section& section : head) {
    const double share = std::clamp((section.height - n - 15 * r) / (55 * r), 0.0, 1.0);
    section.a *= neck + share * (1 - neck);
    section.b *= neck + share * (1 - neck);
  }
  const int part = part_label("head");
  flesh.head = add_limb(builder, "head", part, Frame{}, head, {0, 76 * r}, plan.region(part));
}

// Sections of a long limb with different sizes at its ends: `ends` above `height`, `size` from `reach` mm
// below it.
Sections resized(Sections sections, double height, double reach, double ends, double size) {
  for (Section& section : sections) {
    const double share = std::clamp((height - section.height) / reach, 0.0, 1.0);
    section.a *= ends + share * (size - ends);
    section.b *= ends + share * (size - ends);
  }
  return sections;
}

// Beyond a joint both limbs continue their sections there, so that the skins of a bent joint meet on its
// plane.
constexpr Section elbow{0, 0, 0, 41, 40, 5}, knee{0, 0, 2, 56, 59, 6};

void add_arm(PhantomBuilder& builder, Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const Proportions& p = plan.size;
  const std::size_t s = static_cast<std::size_t>(side);
  const std::string upper_arm = fmt::format("upper_arm_{}", side_name[s]);
  const std::string forearm = fmt::format("forearm_{}", side_name[s]);
  const double g = builder.girth, u = p.upper_arm / 281.7, f = p.forearm / 268.9, l = p.upper_arm;
  constexpr double beyond = 90;
  const Sections upper{at_height(elbow, -l - beyond),  at_height(elbow, -l),
                       {-l + 40 * u, 0, 0, 42, 42, 5}, {-180 * u, 0, -2, 43, 46, 6},
                       {-100 * u, 0, 0, 46, 50, 7},    {-40 * u, 0, 0, 49, 54, 7},
                       {0, 0, 0, 49, 54, 7},           {55, 0, 0, 48, 52, 7}};
  const Sections thick = thickened(upper, p.arm_flesh, g, p.fat);
  const int part = part_label(upper_arm);
  std::vector<HalfSpace> cuts = plan.region(part);
  if (plan.crosses_shoulders) {  // the rest of the arm may lie on either side of the plane
    const Vector3d along = plan.upper_arm[s].axes.col(2),
                   end = plan.upper_arm[s].point({0, 0, -shoulder_reach(plan)});
    const HalfSpace rest{along, along.dot(end)};
    std::vector<HalfSpace> below{rest};
    for (const Cut& cut : plan.cuts)
      if (cut.proximal == part) below.push_back({cut.normal, cut.normal.dot(cut.point)});
    flesh.upper_arm_low[s] =
        add_limb(builder, upper_arm + " low", part, plan.upper_arm[s], thick, {0, 51}, below);
    cuts.push_back(rest.other_side());
  }
  flesh.upper_arm[s] = add_limb(builder, upper_arm, part, plan.upper_arm[s], thick, {0, 51}, cuts);
  constexpr Section wrist{0, 0, 0, 23, 31, 3};
  const Sections lower{at_height(wrist, -p.forearm - 40),
                       at_height(wrist, -p.forearm),
                       {-240 * f, 0, 0, 24, 31, 3.5},
                       {-180 * f, 0, 0, 31, 35, 4},
                       {-100 * f, 0, 0, 41, 43, 5},
                       {-50 * f, 0, 0, 44, 44, 5},
                       at_height(elbow, 0),
                       at_height(elbow, beyond)};
  flesh.forearm[s] = add_limb(builder, forearm, part_label(forearm), plan.forearm[s],
                              resized(thickened(lower, 1, g, p.fat), 0, 50 * f, p.arm_flesh, p.forearm_flesh),
                              {}, plan.region(part_label(forearm)));
}

void add_hand(PhantomBuilder& builder, Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const Proportions& p = plan.size;
  const std::size_t s = static_cast<std::size_t>(side);
  const std::string at = fmt::format("_{}", side_name[s]);
  const double h = p.hand / 187.9, g = lesser(builder.girth);
  const Frame& frame = plan.hand[s];
  const int part = part_label("hand" + at);
  const Sections palm{{-98 * h, 0, 0, 13, 41, 2.5}, {-86 * h, 0, 0, 14.5, 43, 2.5},
                      {-60 * h, 0, 0, 16, 43, 2.5}, {-30 * h, 0, 0, 18, 37, 2.5},
                      {0, 0, 0, 23, 31, 3},         {40, 0, 0, 23, 31, 3}};
  std::vector<HalfSpace> cuts = plan.region(part);
  flesh.palm[s] = add_limb(builder, "palm" + at, part, frame, thickened(palm, p.hand_flesh, g, 1), {}, cuts);

  const auto all = fingers(p);
  for (std::size_t k = 0; k < 5; ++k) {
    const Finger& finger = all[k];
    const Frame along{axes_along(-finger.direction, Vector3d::UnitX()), finger.base};
    const double r = finger.radius;
    const bool thumb = k == 0;
    const Sections sections{{-finger.length, 0, 0, 0.8 * r, 0.8 * r, 1.8},
                            {-0.5 * finger.length, 0, 0, 0.95 * r, 0.95 * r, 1.8},
                            {thumb ? 14.0 : 0.0, 0, 0, r, r, 1.8}};
    std::vector<HalfSpace> limits;
    if (thumb) {  // it stays in front of the palm
      const double palm_edge = 43.1 * p.hand_flesh * lesser(std::max(1.0, builder.girth));
      const Vector3d back = frame.axes.col(1);
      limits.push_back({back, back.dot(frame.origin) - palm_edge});
    }
    flesh.finger[s][k] = add_limb(builder, fmt::format("finger_{}{}", k + 1, at), part, frame.then(along),
                                  sections, {0.8 * r, thumb ? r : 0}, limits);
  }
}

void add_thigh(PhantomBuilder& builder, Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const Proportions& p = plan.size;
  const std::size_t s = static_cast<std::size_t>(side);
  const std::string name = fmt::format("thigh_{}", side_name[s]);
  const double t = p.thigh / 414.4, l = p.thigh;
  const Sections thigh{
      at_height(knee, -l - 80),     at_height(knee, -l),         {-l + 45, 0, 2, 58, 62, 7},
      {-300 * t, 0, 0, 65, 69, 8},  {-200 * t, 0, 0, 76, 82, 9}, {-120 * t, 0, 6, 82, 91, 10},
      {-60 * t, 1, 12, 86, 98, 10}, {0, 4, 14, 87, 104, 10},     {38, 6, 8, 85, 98, 11},
      {75, 6, 2, 84, 93, 13},       {120, 6, 0, 84, 93, 13}};
  std::vector<HalfSpace> cuts = plan.region(part_label(name));
  cuts.push_back(own_half(side));
  cuts.push_back(flank_seat(plan));
  flesh.thigh[s] = add_limb(
      builder, name, part_label(name), plan.thigh[s],
      resized(thickened(thigh, 1, builder.girth, p.fat), 60 - l, 60, p.thigh_flesh, p.shank_flesh), {}, cuts);
}

void add_shank(PhantomBuilder& builder, Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const Proportions& p = plan.size;
  const std::size_t s = static_cast<std::size_t>(side);
  const std::string name = fmt::format("shank_{}", side_name[s]);
  const double k = p.shank / 432.1, l = p.shank;
  constexpr Section ankle{0, 0, 0, 43, 45, 4};
  const Sections shank{at_height(ankle, -l - 60),    at_height(ankle, -l),
                       {-380 * k, 0, 0, 38, 40, 4},  {-300 * k, 0, 3, 40, 43, 5},
                       {-220 * k, 0, 8, 48, 52, 6},  {-140 * k, 0, 12, 56, 60, 6},
                       {-100 * k, 0, 11, 56, 60, 6}, {-45 * k, 0, 4, 54, 57, 6},
                       at_height(knee, 0),           at_height(knee, 80)};
  std::vector<HalfSpace> cuts = plan.region(part_label(name));
  cuts.push_back(own_half(side));
  flesh.shank[s] = add_limb(builder, name, part_label(name), plan.shank[s],
                            thickened(shank, p.shank_flesh, builder.girth, p.fat), {}, cuts);
}

void add_foot(PhantomBuilder& builder, Flesh& flesh, int side) {
  const BodyPlan& plan = builder.plan;
  const Proportions& p = plan.size;
  const std::size_t s = static_cast<std::size_t>(side);
  const std::string name = fmt::format("foot_{}", side_name[s]);
  // the stack lies along the foot: heights run from heel to toe, x lateral, y up from the sole
  Matrix3d along;
  along << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Frame frame = plan.foot[s].then({along, Vector3d(0, 0, -p.ankle)});
  const double f = p.foot / 258.1, up = p.ankle / 64, size = lesser(builder.girth) * p.foot_flesh;
  Sections foot{
      {-52 * f, 0, 30 * up, 34, 36, 3}, {-20 * f, 0, 32 * up, 40, 46, 3}, {0, 0, 34 * up, 43, 52, 3},
      {30 * f, 0, 30 * up, 41, 47, 3},  {70 * f, 0, 24 * up, 42, 37, 3},  {120 * f, 0, 16 * up, 46, 26, 3},
      {160 * f, 0, 12 * up, 49, 18, 3}, {185 * f, 0, 10 * up, 47, 15, 3}, {206.1 * f, 0, 10 * up, 42, 13, 3}};
  for (Section& section : foot) section.a *= size, section.b *= size;
  const Vector3d down = -frame.axes.col(1);
  const HalfSpace sole{down, down.dot(frame.origin)}, sole_fat{down, sole.offset - 4};
  std::vector<HalfSpace> cuts = plan.region(part_label(name));
  cuts.push_back(sole);
  flesh.foot[s] = add_limb(builder, name, part_label(name), frame, foot, {26 * f, 26 * f}, cuts, {sole_fat});
}

}  // namespace

std::array<Finger, 5> fingers(const Proportions& size) {
  const double h = size.hand / 187.9, r = 9.5 * size.hand_flesh;
  const Vector3d down(0, 0, -1);
  const double base = -98 * h, step = 20.3 * size.hand_flesh;
  return {Finger{Vector3d(0, -45 * size.hand_flesh, -36 * h), Vector3d(0, -0.30, -1).normalized(), 72 * h,
                 1.15 * r},
          Finger{Vector3d(0, -8 - step, base), down, 79 * h, r},
          Finger{Vector3d(0, -8, base), down, 89.9 * h, r},
          Finger{Vector3d(0, -8 + step, base), down, 83 * h, r},
          Finger{Vector3d(0, -8 + 2 * step, base), down, 64 * h, 0.93 * r}};
}

Flesh add_flesh(PhantomBuilder& builder) {
  Flesh flesh;
  add_trunk(builder, flesh);
  add_head(builder, flesh);
  add_face(builder, flesh);
  // where they touch, arms take precedence over legs and trunk, and hands over arms
  for (const int side : {left_side, right_side}) {
    add_thigh(builder, flesh, side);
    add_shank(builder, flesh, side);
    add_foot(builder, flesh, side);
  }
  for (const int side : {left_side, right_side}) {
    add_arm(builder, flesh, side);
    add_hand(builder, flesh, side);
  }
  return flesh;
}

}  // namespace borelli
