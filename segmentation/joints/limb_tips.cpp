#include "segmentation/joints/limb_tips.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Flesh {
  std::vector<Vector3d> body, bone;  // voxel centres, mm
};

// Flesh of a hand or foot, including what the segment before it owns distal to the joint. (Near joints bones
// are assigned by distance, and a heel may fall to the shank.)
Flesh flesh_of(const Anatomy& a, const Volume<std::uint8_t>& owner, const std::string& part,
               const std::string& before, const Vector3d& joint, const Vector3d& outwards) {
  const auto label = static_cast<std::uint8_t>(part_label(part)),
             nearer = static_cast<std::uint8_t>(part_label(before));
  const auto& g = a.grid();
  std::vector<Flesh> by_slice(static_cast<std::size_t>(g.size[2]));
  in_turns(g.size[2], a.threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const auto own = owner.at(i, j, k);
          if ((own != label && own != nearer) || !a.body.at(i, j, k)) continue;
          const Vector3d p = g.point(i, j, k);
          if (own == nearer && (p - joint).dot(outwards) < 0) continue;
          Flesh& flesh = by_slice[static_cast<std::size_t>(k)];
          flesh.body.push_back(p);
          if (a.bone.at(i, j, k)) flesh.bone.push_back(p);
        }
  });
  Flesh flesh;
  for (const Flesh& slice : by_slice) {
    flesh.body.insert(flesh.body.end(), slice.body.begin(), slice.body.end());
    flesh.bone.insert(flesh.bone.end(), slice.bone.begin(), slice.bone.end());
  }
  return flesh;
}

// thickness of an end's last layer; its mean gives a blunt end's centre and not a chance voxel
double layer(const Anatomy& a) { return std::max(5.0, 1.5 * a.step()); }

// End of a set of voxels along a direction: the mean of the last layer, moved to the outer face of the
// farthest voxel.
std::optional<Vector3d> end_along(const Anatomy& a, const std::vector<Vector3d>& places,
                                  const Vector3d& direction, double thick) {
  double farthest = -1e9;
  for (const auto& p : places) farthest = std::max(farthest, p.dot(direction));
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const auto& p : places)
    if (p.dot(direction) > farthest - thick) sum += p, ++count;
  if (count == 0) return std::nullopt;
  const Vector3d middle = sum / count;
  return Vector3d(middle + (farthest + 0.5 * a.step() - middle.dot(direction)) * direction);
}

// The point farthest from the wrist: the tip of the third finger, however the hand is turned at the wrist.
std::optional<Vector3d> finger_tip(const Anatomy& a, const std::vector<Vector3d>& hand,
                                   const Vector3d& wrist) {
  const Vector3d* last = nullptr;
  for (const auto& p : hand)
    if (!last || (p - wrist).squaredNorm() > (*last - wrist).squaredNorm()) last = &p;
  if (!last) return std::nullopt;
  const double farthest = (*last - wrist).norm();
  constexpr double finger = 14;  // mm: a finger's thickness
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const auto& p : hand)
    if ((p - *last).norm() < finger && (p - wrist).norm() > farthest - layer(a)) sum += p - wrist, ++count;
  const Vector3d direction = (sum / count).normalized();
  return Vector3d(wrist + (farthest + 0.5 * a.step()) * direction);
}

// unit direction of largest variance
Vector3d longest_axis(const std::vector<Vector3d>& places) {
  Vector3d mean = Vector3d::Zero();
  for (const auto& p : places) mean += p;
  mean /= static_cast<double>(places.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : places) spread += (p - mean) * (p - mean).transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
}

struct FootAxes {
  Vector3d forward, down;  // unit: along the sole to the toes; perpendicular to the sole
};

// Starts with the principal axis of the foot's bones, then follows the sole: the lowest points under heel and
// ball.
FootAxes foot_axes(const Anatomy& a, const Flesh& foot, const Vector3d& ankle, const Vector3d& shank) {
  Vector3d mean = Vector3d::Zero();
  for (const auto& p : foot.bone) mean += p;
  mean /= static_cast<double>(foot.bone.size());
  Vector3d forward = longest_axis(foot.bone);
  if (forward.dot(mean - ankle) < 0) forward = -forward;
  Vector3d down = (shank - shank.dot(forward) * forward).normalized();
  const Vector3d across = forward.cross(down);
  const FootAxes by_bones{forward, down};
  for (int round = 0; round < 3; ++round) {
    double first = 1e9, last = -1e9;
    for (const auto& p : foot.body) {
      first = std::min(first, p.dot(forward));
      last = std::max(last, p.dot(forward));
    }
    std::vector<Vector3d> heel, ball;
    for (const auto& p : foot.body) {
      const double t = (p.dot(forward) - first) / (last - first);
      if (t < 0.3) heel.push_back(p);
      if (t > 0.55 && t < 0.85) ball.push_back(p);
    }
    const auto rear = end_along(a, heel, down, 0.75 * layer(a)),
               front = end_along(a, ball, down, 0.75 * layer(a));
    if (!rear || !front) break;
    Vector3d along = *front - *rear;
    along -= along.dot(across) * across;
    // more than twenty degrees from the bones' axis is no sole: the foot is bent or only partly in view
    if (along.normalized().dot(by_bones.forward) < 0.94) return by_bones;
    forward = along.normalized();
    down = across.cross(forward);
  }
  return {forward, down};
}

void find_hand_end(const Anatomy& a, const Volume<std::uint8_t>& owner, const std::string& side, double scale,
                   Landmarks& marks) {
  const Vector3d wrist = marks.at("wrist" + side).point;
  const auto elbow = marks.find("elbow" + side);
  if (elbow == marks.end()) return;
  const Flesh hand = flesh_of(a, owner, "hand" + side, "forearm" + side, wrist, wrist - elbow->second.point);
  const auto finger = finger_tip(a, hand.body, wrist);
  if (!finger) return;
  const double unseen = 0.5 * a.gaps_unseen(scale);  // an error of the wrist turns the hand's axis
  marks["dactylion_3" + side] = {*finger, std::hypot(6, unseen), 0, "skin: tip of the hand"};
  // de Leva (1996): wrist to third metacarpale 86.2 of 187.9 mm to the dactylion
  marks["metacarpale_3" + side] = {wrist + 0.4588 * (*finger - wrist), std::hypot(15, unseen), 0,
                                   "proportion: between wrist and dactylion"};
}

void find_foot_ends(const Anatomy& a, const Volume<std::uint8_t>& owner, const std::string& side,
                    double scale, Landmarks& marks) {
  const Vector3d ankle = marks.at("ankle" + side).point;
  const auto knee = marks.find("knee" + side);
  if (knee == marks.end()) return;
  const Vector3d shank = (ankle - knee->second.point).normalized();
  const Flesh foot = flesh_of(a, owner, "foot" + side, "shank" + side, ankle, shank);
  if (foot.bone.size() < 4) return;
  const FootAxes axes = foot_axes(a, foot, ankle, shank);
  if (const auto toe = end_along(a, foot.body, axes.forward, layer(a)))
    marks["toe_tip" + side] = {*toe, 5, 0, "skin: foremost point of the foot"};
  // the heel's tendon lies above
  std::vector<Vector3d> below;
  for (const auto& p : foot.body)
    if ((p - ankle).dot(axes.down) > 10 * scale) below.push_back(p);
  if (const auto heel = end_along(a, below, -axes.forward, layer(a)))
    marks["heel" + side] = {*heel, 6, 0, "skin: hindmost point of the foot"};
}

}  // namespace

void find_limb_tips(const Anatomy& a, const Limbs& limbs, const Volume<std::uint8_t>& owner, double scale,
                    Landmarks& marks) {
  for (const int side : {left_side, right_side}) {
    const std::string at = side_suffix(side);
    if (!limbs.arm(side).cut && marks.contains("wrist" + at)) find_hand_end(a, owner, at, scale, marks);
    if (!limbs.leg(side).cut && marks.contains("ankle" + at)) find_foot_ends(a, owner, at, scale, marks);
  }
}

}  // namespace borelli
