#include "segmentation/joint_centres.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "segmentation/hinges.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

std::size_t index_of(const LimbWay& way, double s) {
  return std::min(way.points.size() - 1, static_cast<std::size_t>(std::max(0.0, s) / LimbWay::spacing));
}

// place of the largest section in a stretch of the way, 0 where the way does not hold the stretch's start
double widest(const LimbWay& way, double from, double to) {
  if (way.length() < from) return 0;
  std::size_t best = index_of(way, from);
  for (std::size_t n = best; n <= index_of(way, to); ++n)
    if (way.section[n] > way.section[best]) best = n;
  return LimbWay::spacing * static_cast<double>(best);
}

double narrowest(const LimbWay& way, double from, double to) {
  std::size_t best = index_of(way, from);
  for (std::size_t n = best; n <= index_of(way, to); ++n)
    if (way.section[n] < way.section[best]) best = n;
  return LimbWay::spacing * static_cast<double>(best);
}

double section(const LimbWay& way, double s) { return way.section[index_of(way, s)]; }

// middle of the gap in the bones that is nearest to s, within `reach` of it
std::optional<double> gap_near(const LimbWay& way, double s, double reach) {
  std::optional<double> best;
  for (std::size_t n = index_of(way, s - reach); n <= index_of(way, s + reach); ++n) {
    if (way.off_bone[n] <= 0) continue;
    std::size_t end = n;
    while (end + 1 < way.off_bone.size() && way.off_bone[end + 1] > 0) ++end;
    const double middle = 0.5 * LimbWay::spacing * static_cast<double>(n + end);
    if (!best || std::abs(middle - s) < std::abs(*best - s)) best = middle;
    n = end;
  }
  return best;
}

// a slice of bone square to a direction
struct Section {
  Vector3d centre = Vector3d::Zero();  // its bone's mean, moved into the section's plane
  Vector3d middle = Vector3d::Zero();  // half way between its ends where it is widest
  Vector3d wide = Vector3d::UnitX();   // unit, along which it is widest
  double ratio = 1;                    // of its standard deviations, widest to narrowest
  double area = 0;
};

template <class Visit>
void near_bone(const Anatomy& a, const Limbs& limbs, Limb limb, const Vector3d& point, double reach,
               const Visit& visit) {
  const auto& g = a.grid();
  const Vector3d low = g.index(point - Vector3d::Constant(reach)),
                 high = g.index(point + Vector3d::Constant(reach));
  for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
    for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
      for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
        if (!g.holds(i, j, k) || !a.bone.at(i, j, k)) continue;
        if (limbs.territory.owner.at(i, j, k) != static_cast<std::uint8_t>(limb)) continue;
        const Vector3d p =
            g.point(Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
        if ((p - point).norm() < reach) visit(p);
      }
}

Section section_of(const Anatomy& a, const Limbs& limbs, Limb limb, const Vector3d& point,
                   const Vector3d& along, double half, double reach) {
  Section out;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  near_bone(a, limbs, limb, point, reach, [&](const Vector3d& p) {
    if (std::abs((p - point).dot(along)) > half) return;
    sum += p;
    second += p * p.transpose();
    ++count;
  });
  out.centre = out.middle = point;
  if (count < 4) return out;
  out.centre = sum / count;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
  const Eigen::Matrix3d spread = across * (second / count - out.centre * out.centre.transpose()) * across;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  out.wide = solver.eigenvectors().col(2);
  out.ratio = std::sqrt(solver.eigenvalues()[2] / std::max(1e-9, solver.eigenvalues()[1]));
  out.area = count * std::pow(a.step(), 3) / (2 * half);
  double low = 0, high = 0;
  near_bone(a, limbs, limb, point, reach, [&](const Vector3d& p) {
    if (std::abs((p - point).dot(along)) > half) return;
    low = std::min(low, (p - out.centre).dot(out.wide));
    high = std::max(high, (p - out.centre).dot(out.wide));
  });
  out.centre -= (out.centre - point).dot(along) * along;
  out.middle = out.centre + 0.5 * (low + high) * out.wide;
  return out;
}

// The middle of a bone's broad end, on the joint's axis, and the axis' ends at the bone's sides.
struct JointEnd {
  Vector3d centre, medial, lateral;
  double radius = 0;
  double deviation = 0;
  bool measured = false;  // on a cylinder that the bone's edges agree on
};

// from where the tibia is half as thick again as at its narrowest to the ankle's centre, mm
constexpr double flare_to_ankle = 42;

struct Cylinder {
  double reach, least, most, search;  // see fit_hinge; mm
  double inner, outer;                // where the bone's sides are looked for along the axis
  double agree;                       // share of the rays that must agree on the cylinder
  double above;  // the bone's section this far up the limb stands over the joint and is widest along its axis
};

// farthest place along a direction where bone ends
std::optional<double> side_of_bone(const CloseUp& view, const Vector3d& from, const Vector3d& direction,
                                   double inner, double outer) {
  const auto falls = falls_along(view, from, direction, inner, outer);
  return falls.empty() ? std::nullopt : std::optional(falls.back());
}

JointEnd joint_end(const Anatomy& a, const Limbs& limbs, Limb limb, int side, const Vector3d& point,
                   const Vector3d& along, const Vector3d& left, const Cylinder& shape) {
  const Section s = section_of(a, limbs, limb, point - shape.above * along, along, 6, shape.outer);
  Vector3d axis = (left - left.dot(along) * along).normalized();
  if (s.ratio > 1.15) axis = s.wide;
  if (axis.dot(left) < 0) axis = -axis;
  const Vector3d near = s.centre + shape.above * along;
  JointEnd end{near, near, near, 0, 6, false};
  const CloseUp view = close_up(*a.source, near, shape.outer + shape.search + 8);
  const auto hinge = fit_hinge(view, near, axis, shape.reach, shape.least, shape.most, shape.search);
  if (hinge && hinge->score >= shape.agree) {
    axis = hinge->axis;
    end = {hinge->point, hinge->point, hinge->point, hinge->radius, std::max(1.5, 2 * hinge->deviation),
           true};
  }
  const auto to_left = side_of_bone(view, end.centre, axis, shape.inner, shape.outer);
  const auto to_right = side_of_bone(view, end.centre, -axis, shape.inner, shape.outer);
  const double l = to_left.value_or(0.5 * (shape.inner + shape.outer)),
               r = to_right.value_or(0.5 * (shape.inner + shape.outer));
  const Vector3d at_left = end.centre + l * axis, at_right = end.centre - r * axis;
  if (to_left && to_right) end.centre = 0.5 * (at_left + at_right);
  end.lateral = side == left_side ? at_left : at_right;
  end.medial = side == left_side ? at_right : at_left;
  return end;
}

Landmark found(const Vector3d& point, double deviation, const char* source, double radius = 0) {
  return {point, deviation, radius, source};
}

Vector3d body_left(const Trunk& trunk) {
  const auto& pair = trunk.hip[0] && trunk.hip[1] ? trunk.hip : trunk.shoulder;
  if (!pair[0] || !pair[1]) return Vector3d::UnitX();
  return (pair[0]->centre - pair[1]->centre).normalized();
}

// The body's end along `direction` from `from`, among what lies within `reach` mm of that line: the middle of
// the last few millimetres, so that a blunt end has its middle and not a chance voxel of its face.
std::optional<Vector3d> tip(const Anatomy& a, const Vector3d& from, const Vector3d& direction, double length,
                            double reach) {
  const auto& g = a.grid();
  const double all = length + reach;
  const Vector3d low = g.index(from - Vector3d::Constant(all)),
                 high = g.index(from + Vector3d::Constant(all));
  std::vector<std::pair<double, Vector3d>> places;
  double farthest = 0;
  for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
    for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
      for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
        if (!g.holds(i, j, k) || !a.body.at(i, j, k)) continue;
        const Vector3d d =
            g.point(Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k))) - from;
        const double t = d.dot(direction);
        if (t <= 0 || t > length || (d - t * direction).norm() > reach) continue;
        farthest = std::max(farthest, t);
        places.emplace_back(t, d);
      }
  constexpr double last = 5;
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const auto& [t, d] : places)
    if (t > farthest - last) sum += d, ++count;
  if (count == 0) return std::nullopt;
  const Vector3d middle = sum / count;
  return Vector3d(from + middle + (farthest + 0.5 * a.step() - middle.dot(direction)) * direction);
}

// unit, from heel to toes
Vector3d foot_line(const Anatomy& a, const Limbs& limbs, Limb limb, const Vector3d& ankle, double ankle_way) {
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  near_bone(a, limbs, limb, ankle, 260, [&](const Vector3d& p) {
    const Vector3d index = a.grid().index(p);
    if (limbs.territory.length.at(std::lround(index[0]), std::lround(index[1]), std::lround(index[2])) <
        ankle_way)
      return;
    sum += p;
    second += p * p.transpose();
    ++count;
  });
  if (count < 4) return -Vector3d::UnitY();
  const Vector3d mean = sum / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(second / count - mean * mean.transpose());
  const Vector3d line = solver.eigenvectors().col(2);
  return line.dot(mean - ankle) < 0 ? Vector3d(-line) : line;
}

void find_leg(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, int side, Landmarks& marks) {
  const auto n = static_cast<std::size_t>(side);
  const LimbWay& way = limbs.leg(side);
  if (!trunk.hip[n] || !way.present) return;
  const Limb limb = side == left_side ? Limb::leg_left : Limb::leg_right;
  const std::string at = side_suffix(side);
  const double scale = trunk.scale;
  const Vector3d left = body_left(trunk);
  marks["hip" + at] = found(trunk.hip[n]->centre, std::max(1.5, 2 * trunk.hip[n]->deviation),
                            "bone: sphere on the femoral head", trunk.hip[n]->radius);

  const JointsAlongWay joints = leg_joints(way, scale);
  if (joints.middle == 0) return;
  // the condyles' middle stands one condyle's radius above the joint's gap
  constexpr double condyle = 22;
  const Vector3d knee_line = way.points[index_of(way, joints.middle)];
  const Vector3d down = (knee_line - trunk.hip[n]->centre).normalized();
  const Section end = section_of(a, limbs, limb, knee_line, down, 9, 65);
  const JointEnd k = joint_end(a, limbs, limb, side, end.centre - condyle * scale * down, down, left,
                               {33 * scale, 15 * scale, 30 * scale, 15, 25 * scale, 58 * scale, 0.35, 0});
  marks["knee" + at] =
      found(k.centre, k.deviation,
            k.measured ? "bone: cylinder on the femoral condyles" : "bone: middle of the femoral condyles",
            k.radius);
  marks["knee_medial" + at] = found(k.medial, k.deviation + 2, "bone: femoral epicondyle");
  marks["knee_lateral" + at] = found(k.lateral, k.deviation + 2, "bone: femoral epicondyle");

  if (joints.end == 0) return;
  // straight on along the shank: the way itself turns into the foot before the joint
  const Vector3d flare = way.points[index_of(way, joints.end - flare_to_ankle * scale)];
  const Vector3d along = (flare - k.centre).normalized();
  const JointEnd m =
      joint_end(a, limbs, limb, side, flare + flare_to_ankle * scale * along, along, left,
                {13 * scale, 9 * scale, 24 * scale, 15, 20 * scale, 48 * scale, 0.5, 18 * scale});
  marks["ankle" + at] =
      found(m.centre, m.measured ? m.deviation : 8,
            m.measured ? "bone: cylinder on the talar dome" : "bone: middle of the malleoli", m.radius);
  marks["lateral_malleolus" + at] = found(m.lateral, 8, "bone: malleolus");
  marks["medial_malleolus" + at] = found(m.medial, 8, "bone: malleolus");
  if (way.cut) return;
  // the foot's line is that along which its bones spread most
  const Vector3d forward = foot_line(a, limbs, limb, m.centre, joints.end);
  if (const auto toe = tip(a, m.centre + 30 * scale * along, forward, 260 * scale, 60 * scale))
    marks["toe_tip" + at] = found(*toe, 5, "skin: foremost point of the foot");
  const Vector3d sole = (along - along.dot(forward) * forward).normalized();
  if (const auto heel = tip(a, m.centre + 35 * scale * sole, -forward, 110 * scale, 33 * scale))
    marks["heel" + at] = found(*heel, 6, "skin: hindmost point of the foot");
}

void find_arm(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, int side, Landmarks& marks) {
  const auto n = static_cast<std::size_t>(side);
  const LimbWay& way = limbs.arm(side);
  if (!trunk.shoulder[n] || !way.present) return;
  const Limb limb = side == left_side ? Limb::arm_left : Limb::arm_right;
  const std::string at = side_suffix(side);
  const double scale = trunk.scale;
  const Vector3d left = body_left(trunk);
  marks["shoulder" + at] = found(trunk.shoulder[n]->centre, std::max(2.0, 2 * trunk.shoulder[n]->deviation),
                                 "bone: sphere on the humeral head", trunk.shoulder[n]->radius);

  const JointsAlongWay joints = arm_joints(way, scale);
  if (joints.middle == 0) return;
  constexpr double trochlea = 10;
  const Vector3d elbow_line = way.points[index_of(way, joints.middle)];
  const Vector3d down = (elbow_line - trunk.shoulder[n]->centre).normalized();
  const Section end = section_of(a, limbs, limb, elbow_line, down, 6, 45);
  const JointEnd e =
      joint_end(a, limbs, limb, side, end.centre - trochlea * scale * down, down, left,
                {22 * scale, 6 * scale, 16 * scale, 24, 15 * scale, 45 * scale, 0.5, 22 * scale});
  marks["elbow" + at] = found(
      e.centre, e.deviation,
      e.measured ? "bone: cylinder on the trochlea and capitulum" : "bone: middle of the humeral epicondyles",
      e.radius);
  marks["elbow_medial" + at] = found(e.medial, e.deviation + 2, "bone: humeral epicondyle");
  marks["elbow_lateral" + at] = found(e.lateral, e.deviation + 2, "bone: humeral epicondyle");

  if (joints.end == 0) return;
  // the joint's line stands square to the forearm, between the styloids' sides just above it
  const Vector3d line = way.points[index_of(way, joints.end)];
  const Vector3d along = (line - e.centre).normalized();
  constexpr double up = 10;
  const Section w = section_of(a, limbs, limb, line - up * along, along, 5, 40);
  const Vector3d wrist = w.middle + up * along;
  marks["wrist" + at] = found(wrist, 5, "bone: between radius and carpals");
  if (way.cut) return;
  const Vector3d hand = (way.points[index_of(way, joints.end + 90 * scale)] - wrist).normalized();
  if (const auto finger = tip(a, wrist, hand, 240 * scale, 70)) {
    marks["dactylion_3" + at] = found(*finger, 6, "skin: tip of the hand");
    // de Leva (1996): wrist to third metacarpale 86.2 of 187.9 mm to the dactylion
    marks["metacarpale_3" + at] =
        found(wrist + 0.4588 * (*finger - wrist), 8, "proportion: between wrist and dactylion");
  }
}

}  // namespace

JointsAlongWay leg_joints(const LimbWay& way, double scale) {
  JointsAlongWay joints;
  const double knee = widest(way, 270 * scale, 580 * scale);
  if (knee == 0 || way.length() < knee + 20) return joints;
  const double shaft = narrowest(way, 120 * scale, knee);
  if (section(way, knee) < 2 * section(way, shaft)) return joints;
  joints.middle = gap_near(way, knee, 40 * scale).value_or(knee);

  // past the shank's narrowest place the tibia broadens to the ankle
  const double from = joints.middle + 280 * scale, to = joints.middle + 560 * scale;
  if (way.length() < from + 60) return joints;
  const double thin = narrowest(way, joints.middle + 150 * scale, joints.middle + 340 * scale);
  for (double s = thin; s <= std::min(to, way.length() - 60) && joints.end == 0; s += LimbWay::spacing)
    if (section(way, s) >= 1.5 * section(way, thin)) joints.end = s + flare_to_ankle * scale;
  if (joints.end > way.length() - 40) joints.end = 0;
  return joints;
}

JointsAlongWay arm_joints(const LimbWay& way, double scale) {
  JointsAlongWay joints;
  const double elbow = widest(way, 200 * scale, 420 * scale);
  if (elbow == 0 || way.length() < elbow + 20) return joints;
  const double shaft = narrowest(way, 60 * scale, elbow);
  if (section(way, elbow) < 1.6 * section(way, shaft)) return joints;
  // where no gap is seen: the widest place holds trochlea, radial head and olecranon, below the joint's line
  joints.middle = gap_near(way, elbow, 30 * scale).value_or(elbow - 8 * scale);

  const double from = joints.middle + 130 * scale, to = joints.middle + 340 * scale;
  if (way.length() < from + 60) return joints;
  const double thin = narrowest(way, joints.middle + 60 * scale, joints.middle + 200 * scale);
  // the radius's broad end, then the line of the joint; a slender one is but the widest place thereabouts
  const double last = std::min(to, way.length() - 20);
  double broad = 0;
  for (double s = std::max(thin, from); s <= last && broad == 0; s += LimbWay::spacing)
    if (section(way, s) >= 1.4 * section(way, thin)) broad = widest(way, s, s + 24 * scale);
  if (broad == 0) broad = widest(way, std::min(joints.middle + 200 * scale, last), last);
  joints.end = gap_near(way, broad, 24 * scale).value_or(broad + 9 * scale);
  return joints;
}

void find_limb_landmarks(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  for (const int side : {left_side, right_side}) {
    find_leg(a, trunk, limbs, side, marks);
    find_arm(a, trunk, limbs, side, marks);
  }
  if (marks.contains("hip_left") && marks.contains("hip_right"))
    marks["mid_hip"] = found(0.5 * (marks["hip_left"].point + marks["hip_right"].point),
                             std::max(marks["hip_left"].deviation, marks["hip_right"].deviation),
                             "middle of the hip centres");
}

}  // namespace borelli
