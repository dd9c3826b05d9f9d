#include "pipeline/export/skin_pose.hpp"

#include <cmath>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

SwingTwist swing_twist(const Matrix3d& R, const Vector3d& axis) {
  const Quaternion q = quaternion(R);  // w >= 0
  const double along = axis.dot(q.tail<3>());
  SwingTwist out;
  const double of_twist = std::hypot(q[0], along);
  out.twist = of_twist > 1e-9 ? 2 * std::atan2(along, q[0]) : 0;
  const Quaternion twist{std::cos(out.twist / 2), axis[0] * std::sin(out.twist / 2),
                         axis[1] * std::sin(out.twist / 2), axis[2] * std::sin(out.twist / 2)};
  const Quaternion swing = product(q, conjugate(twist));
  const Vector3d across = swing.tail<3>();
  out.swing = 2 * std::atan2(across.norm(), swing[0]);
  out.swing_axis = across.norm() > 1e-12 ? across.normalized() : Vector3d(axis.unitOrthogonal());
  return out;
}

std::vector<Pose> rest_poses(const Skin& skin) {
  std::vector<Pose> X_WB;
  for (std::size_t b = 0; b < skin.bones.size(); ++b) {
    const SkinPart& part = skin.parts[skin.bones[b].part];
    X_WB.push_back(b < skin.parts.size() ? part.X_WS : Pose{Matrix3d::Identity(), part.centre});
  }
  return X_WB;
}

std::vector<Pose> bone_poses(const Skin& skin, const ScanPoses& X_WS) {
  std::vector<Pose> X_WB, moved;  // moved: each part's displacement from the scan's pose, in the world
  for (const SkinPart& part : skin.parts) {
    const auto given = X_WS.find(part.name);
    const bool has_parent = part.parent >= 0;
    if (given != X_WS.end())
      moved.push_back(given->second * part.X_WS.inverse());
    else
      moved.push_back(has_parent ? moved[static_cast<std::size_t>(part.parent)] : Pose{});
    X_WB.push_back(moved.back() * part.X_WS);
  }
  for (std::size_t b = skin.parts.size(); b < skin.bones.size(); ++b) {
    const SkinBone& bone = skin.bones[b];
    const SkinPart& part = skin.parts[bone.part];
    const Pose& of_parent = moved[static_cast<std::size_t>(part.parent)];
    const Pose relative = of_parent.inverse() * moved[bone.part];
    const SwingTwist turn = swing_twist(relative.R, part.axis);
    const Matrix3d R = rotation_about(turn.swing_axis, bone.swing * turn.swing) *
                       rotation_about(part.axis, bone.twist * turn.twist);
    const Vector3d slid = relative * part.centre - part.centre;
    X_WB.push_back(of_parent * Pose{R, part.centre + bone.swing * slid});
  }
  return X_WB;
}

std::vector<Vector3d> deformed(const Skin& skin, const ScanPoses& X_WS) {
  std::vector<Pose> moved = bone_poses(skin, X_WS);
  const std::vector<Pose> rest = rest_poses(skin);
  for (std::size_t b = 0; b < moved.size(); ++b) moved[b] = moved[b] * rest[b].inverse();
  std::vector<Vector3d> points;
  points.reserve(skin.mesh.points.size());
  for (std::size_t n = 0; n < skin.mesh.points.size(); ++n) {
    Vector3d p = Vector3d::Zero();
    for (std::size_t c = 0; c < 4; ++c)
      if (skin.weights[n][c] > 0)
        p += double(skin.weights[n][c]) * (moved[skin.bones_of[n][c]] * skin.mesh.points[n].cast<double>());
    points.push_back(p);
  }
  return points;
}

}  // namespace borelli
