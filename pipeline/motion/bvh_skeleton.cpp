#include "pipeline/motion/bvh_skeleton.hpp"
#include "dynamics/numbers/rotation_between.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

constexpr double units_per_metre = 100;
constexpr double fixed_within = 1e-9;  // m
constexpr double equal_within = 1e-6;  // of a step
constexpr double degrees = 180 / std::numbers::pi;
constexpr std::array<int, 3> rotation_order{2, 0, 1};  // z, x, y

/// The solids, parents before children.
struct Hierarchy {
  std::vector<int> solids;   ///< indices in the scene
  std::vector<int> parents;  ///< places in this list; -1: the world
};

Hierarchy hierarchy_of(const Scene& scene) {
  Hierarchy out;
  const auto add_children = [&](const std::string& name, int place) {
    for (std::size_t s = 0; s < scene.solids.size(); ++s)
      if (scene.solids[s].parent == name) out.solids.push_back(int(s)), out.parents.push_back(place);
  };
  add_children(world_name, -1);
  for (std::size_t place = 0; place < out.solids.size(); ++place)
    add_children(scene.solids[std::size_t(out.solids[place])].name, int(place));
  return out;
}

/// Poses at equal times.
class EqualTimes {
 public:
  explicit EqualTimes(const Trajectory& motion) : motion_(motion) {
    const std::vector<double>& t = motion.times;
    std::vector<double> steps;
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    if (steps.empty()) return;
    std::ranges::nth_element(steps, steps.begin() + std::ssize(steps) / 2);
    step_ = steps[steps.size() / 2];
    count_ = std::size_t((t.back() - t.front()) / step_ * (1 + equal_within)) + 1;
  }

  double step() const { return step_; }
  std::size_t count() const { return count_; }

  /// Between the two given times around the i-th, linearly along the shortest turn.
  Pose pose(std::size_t i, std::size_t solid) const {
    const std::vector<double>& t = motion_.times;
    const double at = t.front() + double(i) * step_;
    const auto near = std::size_t(std::ranges::lower_bound(t, at - equal_within * step_) - t.begin());
    const std::size_t high = std::min(near, t.size() - 1);
    if (high == 0 || t[high] - at < equal_within * step_) return motion_.pose(high, solid);
    const Pose &a = motion_.pose(high - 1, solid), &b = motion_.pose(high, solid);
    const double share = (at - t[high - 1]) / (t[high] - t[high - 1]);
    return {Quaterniond(a.R).slerp(share, Quaterniond(b.R)).toRotationMatrix(),
            (1 - share) * a.p + share * b.p};
  }

 private:
  const Trajectory& motion_;
  double step_ = 1.0 / 60;  // s, of a motion of one instant
  std::size_t count_ = 1;
};

/// Angles (rad) about z, x, y with Rz Rx Ry = R; of the two triples the one nearer to `before`.
Vector3d zxy_angles(const Matrix3d& R, const Vector3d& before) {
  const double cosine = std::hypot(R(0, 1), R(1, 1));
  Vector3d first;
  first[1] = std::atan2(R(2, 1), cosine);
  // at x = +-90 degrees only the sum or difference of the others counts
  first[0] = cosine < 1e-9 ? before[0] : std::atan2(-R(0, 1), R(1, 1));
  const Matrix3d Ry =
      (Eigen::AngleAxisd(first[0], Vector3d::UnitZ()) * Eigen::AngleAxisd(first[1], Vector3d::UnitX()))
          .toRotationMatrix()
          .transpose() *
      R;
  first[2] = std::atan2(Ry(0, 2), Ry(0, 0));
  Vector3d second = first + Vector3d::Constant(std::numbers::pi);
  second[1] = std::numbers::pi - first[1];
  for (Vector3d* angles : {&first, &second})
    for (int k = 0; k < 3; ++k)
      (*angles)[k] = before[k] + std::remainder((*angles)[k] - before[k], 2 * std::numbers::pi);
  return (first - before).norm() <= (second - before).norm() ? first : second;
}

/// A solid's gravity centre in its frame; its origin if it has no mass.
Vector3d gravity_centre_of(const Solid& solid) {
  Inertial sum;
  if (const auto inertials = inertials_of(solid))
    for (const Inertial& one : *inertials) sum += one;
  return sum.centre;
}

/// The joints of a skeleton and how they lie in their parents over time.
class SkeletonWriter {
 public:
  SkeletonWriter(const Scene& scene, const Trajectory& motion)
      : scene_(scene), motion_(motion), times_(motion), hierarchy_(hierarchy_of(scene)) {
    const Vector3d up =
        scene.gravity.norm() > 0 ? Vector3d(-scene.gravity.normalized()) : Vector3d(Vector3d::UnitZ());
    turn_ = rotation_between(up, Vector3d::UnitY());
  }

  BvhMotion write() {
    for (std::size_t place = 0; place < hierarchy_.solids.size(); ++place) add_joint(place);
    out_.frame_time = times_.step();
    out_.values.resize(Eigen::Index(times_.count()), out_.first_channels().back());
    Eigen::Index column = 0;
    for (std::size_t place = 0; place < hierarchy_.solids.size(); ++place) fill(place, column);
    return std::move(out_);
  }

 private:
  /// X_PS in BVH's axes, m.
  Pose in_parent(std::size_t place, std::size_t i) const {
    const int parent = hierarchy_.parents[place];
    Pose X = times_.pose(i, std::size_t(hierarchy_.solids[place]));
    if (parent >= 0) X = times_.pose(i, std::size_t(hierarchy_.solids[std::size_t(parent)])).inverse() * X;
    return {turn_ * X.R * turn_.transpose(), turn_ * X.p};
  }

  void add_joint(std::size_t place) {
    const Solid& solid = scene_.solids[std::size_t(hierarchy_.solids[place])];
    BvhJoint joint;
    joint.name = solid.name;
    joint.parent = hierarchy_.parents[place] < 0 ? -1 : joints_[std::size_t(hierarchy_.parents[place])];
    const Vector3d first = in_parent(place, 0).p;
    bool moves = joint.parent < 0;
    for (std::size_t i = 1; i < times_.count() && !moves; ++i)
      moves = (in_parent(place, i).p - first).norm() > fixed_within;
    if (moves)
      for (int axis = 0; axis < 3; ++axis) joint.channels.push_back({false, axis});
    else
      joint.offset = units_per_metre * first;
    for (const int axis : rotation_order) joint.channels.push_back({true, axis});
    joints_.push_back(int(out_.joints.size()));
    out_.joints.push_back(joint);
    if (std::ranges::find(hierarchy_.parents, int(place)) != hierarchy_.parents.end()) return;
    const Vector3d end = 2 * units_per_metre * (turn_ * gravity_centre_of(solid));
    out_.joints.push_back({solid.name + "_end", joints_.back(), true, end, {}});
  }

  void fill(std::size_t place, Eigen::Index& column) {
    const BvhJoint& joint = out_.joints[std::size_t(joints_[place])];
    const bool moves = joint.channels.size() > 3;
    Vector3d angles = Vector3d::Zero();
    for (std::size_t i = 0; i < times_.count(); ++i) {
      const Pose X = in_parent(place, i);
      const auto row = Eigen::Index(i);
      if (moves) out_.values.row(row).segment<3>(column) = units_per_metre * X.p.transpose();
      angles = zxy_angles(X.R, angles);
      out_.values.row(row).segment<3>(column + (moves ? 3 : 0)) = degrees * angles.transpose();
    }
    column += std::ssize(joint.channels);
  }

  const Scene& scene_;
  const Trajectory& motion_;
  EqualTimes times_;
  Hierarchy hierarchy_;
  Matrix3d turn_;
  std::vector<int> joints_;  // of the solids in the hierarchy's order
  BvhMotion out_;
};

}  // namespace

Result<BvhMotion> bvh_skeleton(const Scene& scene, const Trajectory& motion) {
  if (motion.times.empty()) return failure("motion", "has no instant, so it cannot be written as BVH");
  bool same = motion.solids.size() == scene.solids.size();
  for (std::size_t s = 0; same && s < scene.solids.size(); ++s)
    same = motion.solids[s] == scene.solids[s].name;
  if (!same || motion.poses.size() != motion.times.size() * motion.solids.size())
    return failure("motion", "does not hold the poses of the scene's solids");
  return SkeletonWriter(scene, motion).write();
}

}  // namespace borelli
