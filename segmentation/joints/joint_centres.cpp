#include "segmentation/joints/joint_centres.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "segmentation/joints/bent_joints.hpp"
#include "segmentation/joints/joint_end.hpp"
#include "segmentation/joints/joints_along_path.hpp"
#include "segmentation/joints/limb_lengths.hpp"
#include "segmentation/joints/lone_heads.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr double child_size = 0.8;  // largest body size of a child, relative to an adult

Landmark found(const Vector3d& point, double deviation, const char* source, double radius = 0) {
  return {point, deviation, radius, source};
}

// If the scan's edge hides one side of a bone, that side's deviation is the bone's width.
void put_sides(const LimbInBody& limb, const std::string& joint, const JointEnd& end, double deviation,
               const char* source, Landmarks& marks) {
  const double wide = (end.lateral - end.medial).norm();
  for (const auto& [name, point] : {std::pair{"_medial", end.medial}, {"_lateral", end.lateral}})
    marks[joint + name + limb.suffix] = found(
        point, limb.anatomy.near_edge(point, 2 * limb.anatomy.step()) ? std::max(deviation, wide) : deviation,
        source);
}

// Tip of a malleolus: the farthest end of bone along the limb, on lines from its side at the joint's level,
// within the bone's thickness.
std::optional<Vector3d> malleolus_tip(const CloseUp& view, const Vector3d& side, const Vector3d& inwards,
                                      const Vector3d& along) {
  constexpr double bone = 150;  // CT number
  const Vector3d across = along.cross(inwards);
  std::vector<std::pair<double, Vector3d>> ends;
  double last = 0;
  for (double in = 2; in <= 7; in += 1)
    for (double q = -8; q <= 8; q += 2) {
      const Vector3d from = side + in * inwards + q * across;
      if (view.at(from) < bone) continue;
      const auto falls = falls_along(view, from, along, 0.5, 32);
      if (falls.empty()) continue;
      ends.emplace_back(falls.front(), from);
      last = std::max(last, falls.front());
    }
  if (ends.size() < 3) return std::nullopt;
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const auto& [t, from] : ends)
    if (t > last - 2.5) sum += from, ++count;
  return Vector3d(sum / count + last * along);
}

// Signed distance along a limb from `line` to the middle of the gap between the bone above and the next one,
// mm. It is robust over lines that begin in the bone, `up` mm above. Empty if the scan does not resolve a
// gap.
std::optional<double> gap_below(const CloseUp& view, const BoneSection& section, const Vector3d& line,
                                const Vector3d& along, double up) {
  constexpr double bone = 165, most = 16;               // CT number; the gap, mm
  const double least = std::max(1.5, 0.9 * view.blur);  // less may be noise at a bone's side
  const Vector3d deep = along.cross(section.wide);
  const Vector3d middle = section.middle + (line - section.middle).dot(along) * along - up * along;
  std::vector<double> ends, starts;  // end of the bone above, start of the bone below
  for (double x = -24; x <= 24; x += 3)
    for (double y = -12; y <= 12; y += 3) {
      const Vector3d from = middle + x * section.wide + y * deep;
      if (view.at(from) < bone) continue;
      double end = 0;  // of the bone above; 0 while the line is in it
      for (double r = 0; r < up + 35; r += 0.5) {
        const bool in_bone = view.at(from + r * along) >= bone;
        if (end == 0 && !in_bone) end = r;
        if (end > 0 && in_bone && r < end + least) end = 0;
        if (end == 0 || (!in_bone && r < end + most)) continue;
        if (in_bone) ends.push_back(end), starts.push_back(r);
        break;
      }
    }
  if (ends.size() < 6) return std::nullopt;
  std::sort(ends.begin(), ends.end());
  std::sort(starts.begin(), starts.end());
  const std::size_t quarter = ends.size() / 4, half = ends.size() / 2;
  // lines that leave a shaft sideways meet no gap, or one anywhere
  if (ends[3 * quarter] - ends[quarter] > 8) return std::nullopt;
  // some lines pass between the next bones to the ones beyond
  return 0.5 * (ends[half] + starts[quarter]) - up;
}

// The femoral condyles. `down`: unit direction of the thigh.
JointEnd find_condyles(const LimbInBody& limb, const JointsAlongPath& joints, const Vector3d& down,
                       const std::optional<BentJoint>& bent_knee) {
  // the centre of the condyles lies one condyle radius above the joint's gap
  constexpr double condyle = 22;
  const double scale = limb.scale;
  const Vector3d knee_line = limb.path.points[limb.path.index(joints.middle)];
  const BoneSection end = section_of(limb, knee_line, down, 9, 65);
  // a section that includes the patella may be deeper than wide
  constexpr double along_left = 0.7;
  JointCylinder shape{33 * scale, 15 * scale, 30 * scale, 22,    25 * scale, 58 * scale,
                      0.35,       1,          0,          false, along_left};
  const auto condyles_at = [&](const Vector3d& centre) {
    return joint_end(limb, centre, down, shape, bent_knee);
  };
  JointEnd k = condyles_at(end.centre - condyle * scale * down);
  // Without a visible gap or waist, the line is only the widest place, which a patella moves to the condyles'
  // own level. On voxels that would not show a gap either, other round structures pass for condyles; below a
  // visible line the tibia does.
  constexpr double below_line = 5;
  if (!k.measured && !bent_knee && limb.anatomy.gaps_unseen(scale) == 0)
    if (const JointEnd lower = condyles_at(end.centre);
        lower.measured && !(joints.middle_seen && (lower.centre - end.centre).dot(down) > below_line * scale))
      k = lower;
  if (!k.measured && !bent_knee && !joints.middle_seen) {
    // the widest place lies 4 to 9 mm below the condyles' centre in the ICRP adults
    constexpr double above_widest = 7, outlines_only = 2;
    shape.agree = outlines_only;
    k = condyles_at(end.centre - above_widest * scale * down);
  }
  return k;
}

// Writes the knee and its epicondyles; the knee's centre, empty if the scan may end above it.
std::optional<Vector3d> find_knee(const LimbInBody& limb, const JointsAlongPath& joints, Landmarks& marks) {
  const Anatomy& a = limb.anatomy;
  const LimbPath& path = limb.path;
  const double scale = limb.scale;
  const auto n = static_cast<std::size_t>(limb.side);
  const Vector3d root = limb.trunk.hip[n] ? limb.trunk.hip[n]->centre : *limb.trunk.femur[n];
  const Vector3d down = (path.points[path.index(joints.middle)] - root).normalized();
  const auto bent_knee = bent_joint(a, limb.limbs, limb.limb, joints.middle, 70 * scale, 220 * scale);
  const JointEnd k = find_condyles(limb, joints, down, bent_knee);
  // near a right angle and beyond, the outlines of both bones overlap, unless their shafts locate the joint
  const double beyond = joints.middle + 150 * scale;
  const Vector3d shank =
      path.points[path.index(beyond)] - path.points[path.index(joints.middle + 50 * scale)];
  constexpr double bent = 0.26;  // cosine of 75 degrees
  const bool folded = path.length() > beyond && shank.normalized().dot(down) < bent;
  // if the scan ends above a knee, the shaft that broadens towards it resembles its end
  constexpr double knee_in_view = 45;
  if (!k.measured && path.cut && a.near_edge(k.centre + knee_in_view * scale * down, a.step()))
    return std::nullopt;
  double deviation = !k.measured && folded && !bent_knee ? 45 * scale : k.deviation;
  // On condyles that the scan's end or side cuts, a cylinder fits only the part in view. The upper end of
  // legs alone may resemble condyles.
  constexpr double condyles_in_view = 30, thigh_in_view = 30, unlike_condyles = 60, half_wide = 40, cut = 12;
  if (a.near_edge(k.centre, half_wide * scale)) deviation = std::max(deviation, cut * scale);
  const bool child = a.size < child_size;  // 17 mm too proximal at 13 mm from the scan's end
  if (path.cut && a.near_edge(k.centre + (child ? 2 : 1) * condyles_in_view * scale * down, a.step()))
    deviation = std::max(deviation, condyles_in_view * scale);
  if (path.headless && a.near_edge(k.centre - thigh_in_view * scale * down, a.step()))
    deviation = std::max(deviation, unlike_condyles * scale);
  marks["knee" + limb.suffix] =
      found(k.centre, deviation,
            k.measured ? "bone: cylinder on the femoral condyles" : "bone: middle of the femoral condyles",
            k.radius);
  put_sides(limb, "knee", k, deviation + 2, "bone: femoral epicondyle", marks);
  return k.centre;
}

// Writes the ankle and the malleoli.
void find_ankle(const LimbInBody& limb, const JointsAlongPath& joints, const Vector3d& knee,
                Landmarks& marks) {
  const Anatomy& a = limb.anatomy;
  const LimbPath& path = limb.path;
  const double scale = limb.scale;
  // continues straight along the shank, since the path itself turns into the foot before the joint
  const Vector3d flare = path.points[path.index(joints.end - flare_to_ankle * scale)];
  const Vector3d along = (flare - knee).normalized();
  const JointEnd m =
      joint_end(limb, flare + flare_to_ankle * scale * along, along,
                {13 * scale, 9 * scale, 24 * scale, 15, 20 * scale, 48 * scale, 0.5, 0, 18 * scale});
  // on voxels that do not resolve a talar dome, other bones may pass for malleoli
  const double unseen = m.measured ? 0 : 2 * a.gaps_unseen(scale);
  const double blunt = std::hypot(unseen, 2 * a.over_fine());  // large voxels show less of the tips
  marks["ankle" + limb.suffix] =
      found(m.centre, m.measured ? m.deviation : std::hypot(8, 0.5 * unseen),
            m.measured ? "bone: cylinder on the talar dome" : "bone: middle of the malleoli", m.radius);
  const CloseUp view = close_up(*a.source, m.centre, 90 * scale);
  for (const auto& [name, place] :
       {std::pair{"lateral_malleolus", m.lateral}, {"medial_malleolus", m.medial}}) {
    const auto end_of_bone = malleolus_tip(view, place, (m.centre - place).normalized(), along);
    marks[name + limb.suffix] = end_of_bone
                                    ? found(*end_of_bone, std::hypot(4, blunt), "bone: tip of the malleolus")
                                    : found(place, std::hypot(15, blunt), "bone: side of the malleolus");
  }
}

void find_leg(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, int side, Landmarks& marks) {
  const Limb name = side == left_side ? Limb::leg_left : Limb::leg_right;
  const LimbInBody limb{a, trunk, limbs, name, side, limbs.leg(side)};
  const auto n = static_cast<std::size_t>(side);
  if (!(trunk.hip[n] || trunk.femur[n]) || !limb.path.present) return;
  if (const auto& head = trunk.hip[n])
    marks["hip" + limb.suffix] = found(
        head->centre, std::hypot(std::max(head->cut ? head->radius : 1.5, 2 * head->deviation), head->rival),
        head->cut ? "bone: sphere on a femoral head that the scan's end may cut"
                  : "bone: sphere on the femoral head",
        head->radius);
  const JointsAlongPath joints = leg_joints(limb.path, limb.scale);
  if (joints.middle == 0 || is_absent(trunk.absent, "shank", limb.suffix)) return;
  const auto knee = find_knee(limb, joints, marks);
  if (!knee || joints.end == 0 || is_absent(trunk.absent, "foot", limb.suffix)) return;
  find_ankle(limb, joints, *knee, marks);
}

struct LikelyWrist {
  Vector3d point = Vector3d::Zero();
  bool by_sections = false;  // it is the wrist from the bones' sections
  double deviation = 0;      // from the alternative places, mm
};

// The wrist from the bones' sections, or a more likely place.
LikelyWrist likely_wrist(std::vector<WristPlace> places, const Vector3d& by_sections, double scale) {
  if (places.empty()) return {by_sections, true, 0};
  constexpr double same = 15, agreement_tells = 1.5;  // mm; log odds
  const auto off = [&](const WristPlace& place) { return (place.point - by_sections).norm(); };
  const auto nearest = std::min_element(places.begin(), places.end(),
                                        [&](const auto& p, const auto& q) { return off(p) < off(q); });
  const bool agrees = off(*nearest) < same * scale;
  if (agrees) nearest->log_odds += agreement_tells;
  const auto best = std::max_element(places.begin(), places.end(),
                                     [](const auto& p, const auto& q) { return p.log_odds < q.log_odds; });
  double sum = 0, squares = 0;
  for (const WristPlace& place : places) {
    const double odds = std::exp(place.log_odds - best->log_odds);
    sum += odds;
    squares += odds * (place.point - best->point).squaredNorm();
  }
  const bool kept = agrees && best == nearest;
  return {kept ? by_sections : best->point, kept, std::sqrt(squares / sum)};
}

// The elbow's bend decides which side is medial, if it is bent (`down` and `along`: unit directions of upper
// arm and forearm). With an arm overhead or turned inwards the sides are exchanged.
void turn_elbow(int side, const Vector3d& down, const Vector3d& along, Landmarks& marks) {
  const std::string at = side_suffix(side);
  const Vector3d bent = along - along.dot(down) * down;
  constexpr double straight = 0.35;  // sine of 20 degrees
  Landmark &medial = marks["elbow_medial" + at], &lateral = marks["elbow_lateral" + at];
  const Vector3d outwards = side_sign(side) * bent.cross(down);
  if (bent.norm() > straight) {
    if (outwards.dot(lateral.point - medial.point) < 0) std::swap(medial, lateral);
    return;
  }
  // A straight elbow: assumes that the arm swung there by the shortest rotation. Its own axial rotation on
  // the path is unknown.
  const Vector3d swung = Eigen::Quaterniond::FromTwoVectors(-Vector3d::UnitZ(), down) *
                         Vector3d(side_sign(side) * Vector3d::UnitX());
  if (swung.dot(lateral.point - medial.point) < 0) std::swap(medial, lateral);
  constexpr double raised = 0.5;  // 120 degrees
  if (down[2] > raised)
    for (Landmark* place : {&medial, &lateral})
      place->deviation = std::max(place->deviation, 0.5 * (lateral.point - medial.point).norm());
}

// A place on the path distal to a joint that gives the limb's direction if the next joint is not found: the
// cut end, or the last place that surely is shaft. Empty if the path ends near the joint.
constexpr double forearm_shaft = 200, shank_shaft = 300;  // mm
std::optional<Vector3d> far_end_of(const LimbPath& path, const Vector3d& joint, double shaft) {
  constexpr double enough = 60;  // mm
  const auto off = [&](const Vector3d& p) { return (p - joint).norm(); };
  auto end = std::prev(path.points.end());
  if (!path.cut) {
    end = std::min_element(path.points.begin(), path.points.end(),
                           [&](const auto& p, const auto& q) { return off(p) < off(q); });
    while (std::next(end) != path.points.end() && off(*end) < shaft) ++end;
  }
  return off(*end) > enough ? std::optional(*end) : std::nullopt;
}

// Writes the elbow and its epicondyles; its centre, empty if the scan may end above it. `down`: unit
// direction of the upper arm.
std::optional<Vector3d> find_elbow(const LimbInBody& limb, const JointsAlongPath& joints,
                                   const Vector3d& down, Landmarks& marks) {
  const Anatomy& a = limb.anatomy;
  const LimbPath& path = limb.path;
  const double scale = limb.scale;
  constexpr double trochlea = 10;
  const Vector3d elbow_line = path.points[path.index(joints.middle)];
  const BoneSection end = section_of(limb, elbow_line, down, 6, 45);
  const JointEnd e = joint_end(limb, end.centre - trochlea * scale * down, down,
                               {22 * scale, 6 * scale, 16 * scale, 24, 15 * scale, 45 * scale, 0.5, 1,
                                22 * scale, a.over_fine() > 0.5},
                               bent_joint(a, limb.limbs, limb.limb, joints.middle, 50 * scale, 160 * scale));
  // if the scan ends above an elbow, the shaft that broadens towards it resembles its end
  constexpr double joint_in_view = 30;
  if (path.cut && a.near_edge(e.centre + joint_in_view * scale * down, a.step())) return std::nullopt;
  // Extra deviation on large voxels: of epicondyles by outlines above 5 mm, of cylinders above 4 mm (9 mm off
  // in 2 of 6 children at 3 mm, whose voxels are as large relative to the body).
  const double edge = std::max(std::cbrt(a.source->grid.voxel_volume()), a.step());
  const double coarse = a.size > child_size ? 0
                        : e.measured        ? (edge > 4 ? 8 : 0)
                                            : 24 * std::max(0.0, edge - 5 * scale);
  const double deviation = std::hypot(e.deviation, coarse);
  marks["elbow" + limb.suffix] = found(
      e.centre, deviation,
      e.measured ? "bone: cylinder on the trochlea and capitulum" : "bone: middle of the humeral epicondyles",
      e.radius);
  put_sides(limb, "elbow", e, deviation + 2, "bone: humeral epicondyle", marks);
  return e.centre;
}

// Writes the wrist; returns the unit direction of the forearm.
Vector3d find_wrist(const LimbInBody& limb, const JointsAlongPath& joints, const Vector3d& elbow,
                    Landmarks& marks) {
  const Anatomy& a = limb.anatomy;
  const LimbPath& path = limb.path;
  const double scale = limb.scale;
  // the joint's line is perpendicular to the forearm, between the sides of the styloids just above it
  const Vector3d by_sections = path.points[path.index(joints.end)];
  const LikelyWrist likely = a.gap_may_fuse(scale)
                                 ? likely_wrist(wrist_places(path, elbow, scale), by_sections, scale)
                                 : LikelyWrist{by_sections, true, 0};
  const Vector3d& line = likely.point;
  const Vector3d along = (line - elbow).normalized();
  const double reach = (likely.by_sections ? 25 : 12) * scale;  // maximum distance of the gap from there
  constexpr double up = 10;
  BoneSection w = section_of(limb, line - up * along, along, 5, 40);
  Vector3d wrist = w.middle + up * along;
  // the path gives the gap to within some voxels; the scan itself is more precise
  const CloseUp view = close_up(*a.source, wrist, 90);
  for (int round = 0; round < 2; ++round)
    for (const double start : {10.0, 22.0}) {
      const auto gap = gap_below(view, w, wrist, along, start * scale);
      if (!gap || std::abs(*gap) > reach) continue;
      w = section_of(limb, wrist + (*gap - up) * along, along, 5, 40);
      wrist = w.middle + up * along;
      break;
    }
  // if the scan cuts an arm and the voxels show no gap, a dip in the forearm's section may pass for the wrist
  constexpr double hand_tells = 90;
  const double to_end = (path.points.back() - wrist).norm();
  const bool may_be_beyond = path.cut && a.gap_may_fuse(scale) && to_end < hand_tells * scale;
  double doubt = std::max(likely.deviation, may_be_beyond ? 0.5 * to_end : 0.0);
  // A gap among the hand's bones may pass for the wrist. If forearm and hand would then have lengths that no
  // arm has, their usual lengths place the wrist. This needs the whole hand in view.
  constexpr double most = 4;  // standard deviations
  const char* source = "bone: between radius and carpals";
  constexpr double in_view = 30;  // mm
  const bool ends = !path.cut && !a.near_edge(path.points.back(), in_view);
  if (const auto usual = usual_wrist(path, elbow); usual && ends) {
    const double off = (usual->point - wrist).norm();
    if (off > most * hand_share_varies * usual->length) {
      wrist = usual->point, doubt = std::max(doubt, off / 2);
      source = "proportion: between elbow and the hand's end";
    }
  }
  marks["wrist" + limb.suffix] = found(wrist, std::hypot(5, a.gaps_unseen(scale), doubt), source);
  return along;
}

void find_arm(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, int side, Landmarks& marks) {
  const Limb name = side == left_side ? Limb::arm_left : Limb::arm_right;
  const LimbInBody limb{a, trunk, limbs, name, side, limbs.arm(side)};
  const LimbPath& path = limb.path;
  const auto n = static_cast<std::size_t>(side);
  if (!trunk.shoulder[n] || !path.present) return;
  const FoundSphere& head = *trunk.shoulder[n];
  marks["shoulder" + limb.suffix] =
      found(head.centre, std::hypot(std::max(head.cut ? head.radius : 2.0, 2 * head.deviation), head.rival),
            head.cut ? "bone: sphere on a humeral head that the scan's end may cut"
                     : "bone: sphere on the humeral head",
            head.radius);
  const JointsAlongPath joints = arm_joints(path, limb.scale);
  if (joints.middle == 0 || is_absent(trunk.absent, "forearm", limb.suffix)) return;
  const Vector3d down = (path.points[path.index(joints.middle)] - head.centre).normalized();
  const auto elbow = find_elbow(limb, joints, down, marks);
  if (!elbow) return;
  if (joints.end == 0 || is_absent(trunk.absent, "hand", limb.suffix)) {
    if (const auto beyond = far_end_of(path, *elbow, forearm_shaft * limb.scale))
      turn_elbow(side, down, (*beyond - *elbow).normalized(), marks);
    return;
  }
  turn_elbow(side, down, find_wrist(limb, joints, *elbow, marks), marks);
}

// Adds the ends of forearms and shanks whose far joint is missing: where the scan cuts them, or as far as the
// shaft surely goes. The ends give the segment's direction.
void place_far_ends(const Limbs& limbs, double scale, Landmarks& marks) {
  constexpr double beside = 12;  // mm: the path follows one of two bones
  struct LowerLimb {
    const LimbPath* path;
    const char *joint, *beyond, *name;
    double shaft;
  };
  for (const int side : {left_side, right_side})
    for (const LowerLimb& limb : {LowerLimb{&limbs.arm(side), "elbow", "wrist", "forearm_end", forearm_shaft},
                                  LowerLimb{&limbs.leg(side), "knee", "ankle", "shank_end", shank_shaft}}) {
      const std::string at = side_suffix(side);
      const auto from = marks.find(limb.joint + at);
      if (!limb.path->present || from == marks.end() || marks.contains(limb.beyond + at)) continue;
      if (const auto end = far_end_of(*limb.path, from->second.point, limb.shaft * scale))
        marks[limb.name + at] = found(
            *end, beside, limb.path->cut ? "bone: where the scan cuts it" : "bone: as far as it surely goes");
    }
}

}  // namespace

void find_limb_landmarks(const Anatomy& a, const Trunk& trunk, const Limbs& limbs, Landmarks& marks) {
  // each limb writes its own landmarks
  std::array<Landmarks, 4> found_on;
  in_turns(std::ssize(found_on), a.threads, [&](std::int64_t first, std::int64_t last) {
    for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n)
      (n % 2 ? find_arm : find_leg)(a, trunk, limbs, n < 2 ? left_side : right_side, found_on[n]);
  });
  for (Landmarks& limb : found_on) marks.merge(limb);
  place_cut_ankles(trunk, limbs, marks);
  place_far_ends(limbs, trunk.scale, marks);
  doubt_unlike_lengths(trunk, limbs, marks, a.gap_may_fuse(trunk.scale));
  if (marks.contains("hip_left") && marks.contains("hip_right"))
    marks["mid_hip"] = found(0.5 * (marks["hip_left"].point + marks["hip_right"].point),
                             std::max(marks["hip_left"].deviation, marks["hip_right"].deviation),
                             "middle of the hip centres");
  put_middle_of_hips(trunk, marks);
}

}  // namespace borelli
