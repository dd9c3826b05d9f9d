#include "pipeline/body/skeleton.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <span>

#include "pipeline/body/joint_axes.hpp"
#include "pipeline/body/joint_ranges.hpp"
#include "pipeline/body/segment_frames.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"
#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/part_words.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;
constexpr double degree = std::numbers::pi / 180;

// Rest angle of the joint springs in the tuck. It is the middle of the oscillation: an undamped joint turns
// by twice as much. About the patient's left axis; flexion that moves a downward-pointing part forwards is
// negative there.
struct TuckAngle {
  std::string_view joint;
  double about_left_deg;
};
constexpr std::array<TuckAngle, 7> tuck_angles{{{"spine_lower", 12},
                                                {"spine_upper", 12},
                                                {"neck", 12},
                                                {"hip", -72},
                                                {"knee", 90},
                                                {"shoulder", -20},
                                                {"elbow", -35}}};

// Least room before a stop, since a stop yields. If the scan's pose is at the end of a range (a fully turned
// wrist), the joint starts this far inside the stop's spring; otherwise the smallest motion would pass the
// end.
constexpr double least_room_deg = 2;

std::string without_side(std::string_view joint) {
  for (const std::string_view side : {"_left", "_right"})
    if (joint.ends_with(side)) joint.remove_suffix(side.size());
  return std::string(joint);
}

double tuck_angle(const std::string& joint) {
  for (const auto& angle : tuck_angles)
    if (angle.joint == joint) return angle.about_left_deg * degree;
  return 0;
}

// Names for a free body: three translations and a ball.
std::array<std::string, 4> free_coordinates(std::string_view part) {
  const std::string name(part);
  return {name + "_x", name + "_y", name + "_z", name + "_turn"};
}

std::optional<Vector3d> point_in_world(const Landmarks& landmarks, const std::string& name) {
  const auto it = landmarks.find(name);
  if (it == landmarks.end()) return std::nullopt;
  return Vector3d(1e-3 * it->second.point);
}

std::vector<Part> tree_of(const PartInertials& present) {
  std::vector<std::string> names;
  for (const auto& [name, inertial] : present) names.push_back(name);
  return segment_tree(names);
}

// Origin of a part: the joint to its parent (lower trunk: midway between the hips), or else its gravity
// centre.
Vector3d part_origin(const Part& part, const PartInertials& present, const Landmarks& landmarks) {
  const std::string name(part.parent.empty() ? "mid_hip" : part.joint);
  if (const auto centre = point_in_world(landmarks, name)) return *centre;
  return present.find(part.name)->second.centre;
}

class Builder {
 public:
  Builder(const PartInertials& present, const Landmarks& landmarks, const SkeletonOptions& options)
      : present_(present),
        tree_(tree_of(present)),
        landmarks_(landmarks),
        options_(options),
        axes_(trunk_axes(landmarks)) {}

  Result<Skeleton> build();

 private:
  std::optional<Vector3d> point(const std::string& name) const { return point_in_world(landmarks_, name); }
  Vector3d origin(const Part& part) const { return part_origin(part, present_, landmarks_); }
  bool is_root(const Part& part) const { return part.parent.empty() || !present_.contains(part.parent); }
  double tuck() const { return options_.leap ? options_.leap->tuck : 0; }
  Inertial subtree(const Part& part) const;
  std::vector<Switch> free_in_space(const Part& part);
  std::vector<Switch> hinge(const Part& part, const Vector3d& offset);
  std::vector<Switch> ball(const Part& part, const Part& parent, const Vector3d& offset);
  std::vector<Switch> joint(const Part& part);
  double inertia_about(const Part& part, const Vector3d& axis) const;
  void add_muscle(const Part& part, const Vector3d& axis, double rest, bool is_hinge);
  void add_stop(const Part& part, const Vector3d& axis, std::vector<Range> ranges, const double* start);
  std::optional<Vector3d> hinge_axis(const Part& part, double flexion_sign) const;
  double flexion_in_scan(const Part& part, const Vector3d& axis) const;
  double flexion_deviation(const Part& part) const;
  void warn(std::string text) {
    result_.warnings.push_back({WarningKind::joint, Severity::note, std::move(text)});
  }
  Vector3d ball_deviation(const Part& part, const Part& parent) const;

  const PartInertials& present_;
  std::vector<Part> tree_;  // the parts that exist
  const Landmarks& landmarks_;
  const SkeletonOptions& options_;
  Eigen::Matrix3d axes_;  // columns: the trunk's left, back, up
  Inertial whole_;
  Skeleton result_;
};

Inertial Builder::subtree(const Part& part) const {
  Inertial sum = present_.find(part.name)->second;
  for (const Part& child : tree_)
    if (child.parent == part.name) sum += subtree(child);
  return sum;
}

// Three translations and a ball, with the leap's initial velocities: the whole body rotates rigidly about its
// gravity centre.
std::vector<Switch> Builder::free_in_space(const Part& part) {
  const Vector3d at = origin(part);
  const Vector3d omega =
      options_.leap ? Vector3d(options_.leap->somersault_rate_deg * degree * axes_.col(0)) : Vector3d::Zero();
  const double rise = options_.leap ? -result_.scene.gravity.z() * options_.leap->flight_time / 2 : 0;
  const Vector3d velocity = Vector3d(0, 0, rise) + omega.cross(at - whole_.centre);
  const auto names = free_coordinates(part.name);
  std::vector<Switch> switches;
  for (int i = 0; i < 3; ++i)
    switches.push_back(
        {.kind = Translation{Vector3d::Unit(i)}, .coordinate = names[i], .q = {at[i]}, .v = {velocity[i]}});
  switches.push_back({.kind = Ball{}, .coordinate = names[3], .v = {omega.x(), omega.y(), omega.z()}});
  return switches;
}

// The line through the epicondyles, directed so that flexion is positive: on the left towards lateral times
// `flexion_sign`, on the right the opposite, whatever the limb's pose. If the joint would then hyperextend
// impossibly, the epicondyles are interchanged.
std::optional<Vector3d> Builder::hinge_axis(const Part& part, double flexion_sign) const {
  const std::string joint(part.joint);
  const std::string kind = without_side(joint), side = joint.substr(kind.size());
  const auto medial = point(kind + "_medial" + side), lateral = point(kind + "_lateral" + side);
  if (!medial || !lateral || (*lateral - *medial).norm() < 1e-6) return std::nullopt;
  constexpr double backwards = 20 * degree;
  const Vector3d axis = flexion_sign * (side == "_left" ? 1 : -1) * (*lateral - *medial).normalized();
  return flexion_in_scan(part, axis) < -backwards ? Vector3d(-axis) : axis;
}

// Angle between the long axes of the two segments about the hinge, in the scan's pose.
double Builder::flexion_in_scan(const Part& part, const Vector3d& axis) const {
  const std::string joint(part.joint);
  const bool knee = joint.starts_with("knee");
  const std::string side = joint.substr(joint.find('_'));
  const auto before = point((knee ? "hip" : "shoulder") + side), here = point(joint),
             after = point((knee ? "ankle" : "wrist") + side);
  if (!before || !here || !after) return 0;
  const auto flat = [&](const Vector3d& v) { return Vector3d(v - axis.dot(v) * axis); };
  const Vector3d a = flat(*here - *before), b = flat(*after - *here);
  return std::atan2(axis.dot(a.cross(b)), a.dot(b));
}

// Standard deviation of a hinge's angle, rad, from its three joint centres: each counts normal to the segment
// to its neighbour; the hinge's own centre turns both segments.
double Builder::flexion_deviation(const Part& part) const {
  const std::string joint(part.joint);
  const bool knee = joint.starts_with("knee");
  const std::string side = joint.substr(joint.find('_'));
  const auto before = landmarks_.find((knee ? "hip" : "shoulder") + side), here = landmarks_.find(joint),
             after = landmarks_.find((knee ? "ankle" : "wrist") + side);
  if (before == landmarks_.end() || here == landmarks_.end() || after == landmarks_.end()) return 0;
  const double above = (here->second.point - before->second.point).norm(),
               below = (after->second.point - here->second.point).norm();
  return std::hypot(before->second.deviation / above, after->second.deviation / below,
                    here->second.deviation * (1 / above + 1 / below));
}

std::vector<Switch> Builder::hinge(const Part& part, const Vector3d& offset) {
  const std::string name(part.joint), kind = without_side(name);
  const double sign = kind == "knee" ? 1 : -1;
  auto axis = hinge_axis(part, sign);
  if (!axis) {
    warn(fmt::format("{}: no epicondyles were found, so the hinge follows the patient's left-right axis",
                     in_words(name)));
    axis = Vector3d(sign * axes_.col(0));
  }
  // the part's frame has the patient's axes in the scan's pose; the coordinate is the anatomical flexion,
  // zero when straight
  const double flexion = flexion_in_scan(part, *axis);
  Range range = joint_ranges().at(kind + " flexion");
  if (flexion < range.lower || flexion > range.upper) {
    // an excess within the landmarks' uncertainty gives no warning
    const double room = std::max(usual_range_room, flexion_deviation(part));
    if (range.lower - flexion > room || flexion - range.upper > room)
      result_.warnings.push_back(outside_range(name, "flexion", flexion, range));
    range = {std::min(range.lower, flexion), std::max(range.upper, flexion)};
  }
  add_muscle(part, *axis, flexion + tuck() * sign * tuck_angle(kind), true);
  add_stop(part, *axis, {range}, &flexion);
  Fixed straight{{rotation_about(*axis, -flexion), offset}};
  return {{.kind = straight, .coordinate = ""},
          {.kind = Rotation{*axis}, .coordinate = name, .q = {flexion}, .ranges = {range}}};
}

std::vector<Switch> Builder::joint(const Part& part) {
  if (is_root(part)) {
    if (!part.parent.empty())
      warn(fmt::format("{}: its {} is missing, so it moves freely in space", in_words(part.name),
                       in_words(part.parent)));
    return free_in_space(part);
  }
  const Part& parent = *std::ranges::find(tree_, part.parent, &Part::name);
  const Vector3d offset = origin(part) - origin(parent);
  Switch to_joint{.kind = Fixed{{Eigen::Matrix3d::Identity(), offset}}, .coordinate = ""};
  const std::string name(part.joint), kind = without_side(name);
  if (!point(name)) {
    warn(fmt::format("{}: no joint centre was found, so {} is welded to {}", in_words(name),
                     in_words(part.name), in_words(part.parent)));
    return {to_joint};
  }
  if (kind == "knee" || kind == "elbow") return hinge(part, offset);
  add_muscle(part, axes_.col(0), tuck() * tuck_angle(kind), false);
  return ball(part, parent, offset);
}

// A ball about the anatomical axes, zero in the anatomical position. Fixed rotations on both sides give the
// part's frame the patient's axes at the start, like its parent's.
std::vector<Switch> Builder::ball(const Part& part, const Part& parent, const Vector3d& offset) {
  const std::string name(part.joint);
  const auto frame = [&](const Part& of) {
    auto found = segment_frame(of.name, landmarks_, present_.find(of.name)->second);
    if (found && found->axes == patients_axes) found.reset();  // not the body's axes: no ranges about them
    return found;
  };
  const auto before = frame(parent), after = frame(part);
  if (!before || !after) {
    warn(fmt::format("{}: the landmarks of {} do not define its axes, so the joint has no ranges",
                     in_words(name), in_words(before ? part.name : parent.name)));
    return {{.kind = Fixed{{Eigen::Matrix3d::Identity(), offset}}, .coordinate = ""},
            {.kind = Ball{}, .coordinate = name}};
  }
  const JointAxes joint = joint_axes(name);
  const Eigen::Matrix3d R_PA = before->R_WA * joint.R_FA, R_SB = after->R_WA * joint.R_FA;
  const Quaternion start = quaternion(R_PA.transpose() * R_SB);
  const Vector3d from = logarithm(start);
  const auto ranges = ranges_with_start(joint, from, name, result_.warnings, ball_deviation(part, parent));
  add_stop(part, axes_.col(0), {ranges.begin(), ranges.end()}, from.data());
  return {{.kind = Fixed{{R_PA, offset}}, .coordinate = ""},
          {.kind = Ball{},
           .coordinate = name,
           .q = {start[0], start[1], start[2], start[3]},
           .ranges = options_.leap ? std::vector<Range>(ranges.begin(), ranges.end()) : std::vector<Range>()},
          {.kind = Fixed{{R_SB.transpose(), Vector3d::Zero()}}, .coordinate = ""}};
}

// Standard deviation of a ball's start about each of its axes, rad: root sum of squares of its rotations when
// each coordinate of each landmark moves by its deviation.
Vector3d Builder::ball_deviation(const Part& part, const Part& parent) const {
  const JointAxes joint = joint_axes(part.joint);
  const auto start = [&](const Landmarks& marks) -> std::optional<Vector3d> {
    const auto before = segment_frame(parent.name, marks, present_.find(parent.name)->second),
               after = segment_frame(part.name, marks, present_.find(part.name)->second);
    if (!before || !after) return std::nullopt;
    return logarithm(
        quaternion(joint.R_FA.transpose() * before->R_WA.transpose() * after->R_WA * joint.R_FA));
  };
  const auto usual = start(landmarks_);
  if (!usual) return Vector3d::Zero();
  Landmarks marks = landmarks_;
  Vector3d squares = Vector3d::Zero();
  for (auto& [name, mark] : marks) {
    if (mark.deviation <= 0) continue;
    for (int c = 0; c < 3; ++c) {
      const double at = mark.point[c];
      mark.point[c] += mark.deviation;
      if (const auto moved = start(marks)) squares += (*moved - *usual).cwiseAbs2();
      mark.point[c] = at;
    }
  }
  return squares.cwiseSqrt();
}

// Inertia that moves at a part's joint about an axis.
double Builder::inertia_about(const Part& part, const Vector3d& axis) const {
  const Inertial far = subtree(part);
  return joint_inertia(far, whole_ - far, origin(part), axis);
}

// Adds a stop at each end of a joint's ranges.
void Builder::add_stop(const Part& part, const Vector3d& axis, std::vector<Range> ranges,
                       const double* start) {
  if (!options_.leap) return;
  const double omega = 2 * std::numbers::pi * Leap::stop_frequency;
  const double stiffness = omega * omega * inertia_about(part, axis);
  if (stiffness == 0) return;
  for (Range& range : ranges) {
    const double room = Leap::stop_room_deg * degree, at = *start++;
    const double least = std::min(least_room_deg * degree, (range.upper - range.lower) / 2);
    range = {std::min(range.lower + room, std::max(range.lower + least, at)),
             std::max(range.upper - room, std::min(range.upper - least, at))};
  }
  const std::string joint_name(part.joint);
  result_.scene.efforts.push_back(
      {joint_name + "_stop",
       LimitSpring{{joint_name}, stiffness, Leap::stop_dissipation, std::move(ranges)}});
}

// Adds a passive spring and damper with the leap's natural frequency and damping ratio.
void Builder::add_muscle(const Part& part, const Vector3d& axis, double rest, bool is_hinge) {
  if (!options_.leap) return;
  const double inertia = inertia_about(part, axis);
  const double omega = 2 * std::numbers::pi * options_.leap->muscle_frequency;
  const double stiffness = omega * omega * inertia,
               damping = 2 * options_.leap->damping_ratio * omega * inertia;
  const std::string joint_name(part.joint), name = joint_name + "_muscle";
  if (stiffness == 0 && damping == 0) return;
  if (is_hinge)
    result_.scene.efforts.push_back({name, CoordinateSpring{{joint_name}, stiffness, damping, rest}});
  else
    result_.scene.efforts.push_back({name, TorsionSpring{{std::string(part.name)},
                                                         {std::string(part.parent)},
                                                         stiffness,
                                                         damping,
                                                         Vector3d(rest * axis)}});
}

Result<Skeleton> Builder::build() {
  Scene& scene = result_.scene;
  scene.name = options_.name;
  scene.description = "A body made from a scan: x, y and z are the patient's left, back and up.";
  if (options_.leap)
    scene.description +=
        " It leaps, somersaults backwards and\nlands; there is no contact. Springs pull each passive joint "
        "towards a tuck, and away from the\nends of its ranges.";
  for (const std::string& part : options_.absent)
    scene.description += (&part == &options_.absent.front() ? "\nStated as absent: " : ", ") + part +
                         (&part == &options_.absent.back() ? "." : "");
  for (const auto& [name, inertial] : present_) {
    if (!is_segment(name)) return bad_use(name, "is not a part of the body");
    whole_ += inertial;
  }
  if (present_.empty()) return failure("skeleton", "no part was found, so nothing can move");

  for (const Part& part : tree_) {
    Solid solid;
    solid.name = std::string(part.name);
    solid.parent = is_root(part) ? std::string(world_name) : std::string(part.parent);
    solid.switches = joint(part);
    solid.inertials = {
        present_.find(part.name)->second.expressed_in(Eigen::Matrix3d::Identity(), -origin(part))};
    scene.solids.push_back(std::move(solid));
  }
  if (options_.leap) scene.simulation.end_time = options_.leap->flight_time;
  scene.simulation.output_interval = 1.0 / 60;
  return std::move(result_);
}

}  // namespace

PartInertials movable_parts(const InertiaTable& table, std::vector<Warning>& warnings) {
  PartInertials present;
  for (const InertiaRow& row : table.rows) {
    if (row.completeness == Completeness::absent || row.inertial.mass <= 0) continue;
    if (!is_segment(row.part)) {
      warnings.push_back({WarningKind::part, Severity::note,
                          in_words(row.part) + " is not in the skeleton's tree and does not move"});
      continue;
    }
    if (!row.flaw.empty()) {
      warnings.push_back({WarningKind::part, Severity::doubt,
                          in_words(row.part) + " is left out of the scene: " + row.flaw});
      continue;
    }
    // a stump is the complete remainder of its part
    if (row.completeness == Completeness::cut &&
        !(!row.notes.empty() && row.notes.front().starts_with(stump_note)))
      warnings.push_back(joined_warning(WarningKind::part, Severity::note,
                                        "the scene moves only the labelled piece of these cut parts",
                                        in_words(row.part), row.notes.empty() ? "" : row.notes.front()));
    present[row.part] = row.inertial;
  }
  return present;
}

std::vector<std::string> stated_absent(const InertiaTable& table) {
  std::vector<std::string> absent;
  for (const InertiaRow& row : table.rows)
    if (row.completeness == Completeness::absent &&
        std::ranges::find(row.notes, stated_as_absent) != row.notes.end())
      absent.push_back(row.part);
  return absent;
}

SkeletonNames skeleton_names(const std::vector<std::string>& segments) {
  SkeletonNames out;
  for (const std::string& name : segments)
    for (const Part& part : segment_tree(std::span(&name, 1))) {
      out.solids.push_back(name);
      if (!part.joint.empty()) out.coordinates.emplace_back(part.joint);
      for (const std::string& free : free_coordinates(name)) out.coordinates.push_back(free);
    }
  return out;
}

std::map<std::string, Pose, std::less<>> scan_poses(const PartInertials& present,
                                                    const Landmarks& landmarks) {
  std::map<std::string, Pose, std::less<>> X_WS;
  for (const Part& part : tree_of(present))
    X_WS[std::string(part.name)].p = part_origin(part, present, landmarks);
  return X_WS;
}

double joint_inertia(const Inertial& one_side, const Inertial& other_side, const Vector3d& joint,
                     const Vector3d& axis) {
  const double one = axis.dot(one_side.tensor_about(joint) * axis);
  const double other = axis.dot(other_side.tensor_about(joint) * axis);
  return one + other > 0 ? one * other / (one + other) : 0;
}

Result<Skeleton> build_skeleton(const PartInertials& present, const Landmarks& landmarks,
                                const SkeletonOptions& options) {
  return Builder(present, landmarks, options).build();
}

}  // namespace borelli
