#include "segmentation/vocabulary/part_planes.hpp"

#include <algorithm>

#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

constexpr int head = part_label("head"), upper_trunk = part_label("upper_trunk"),
              middle_trunk = part_label("middle_trunk"), lower_trunk = part_label("lower_trunk");

bool beyond(const Cut& cut, const Eigen::Vector3d& point) { return (point - cut.point).dot(cut.normal) > 0; }

}  // namespace

PartPlanes::PartPlanes(const Landmarks& landmarks, Convention convention,
                       const std::function<void(Cut&)>& change)
    : convention_(convention), cuts_(cut_planes(landmarks, convention)) {
  if (change) std::ranges::for_each(cuts_, change);
  for (std::size_t label = 1; label < parts.size(); ++label)
    joint_seen_[label] = landmarks.contains(parts[label].joint);
  for (const Cut& cut : cuts_) by_distal_[static_cast<std::size_t>(cut.distal)] = &cut;
  const auto l = landmarks.find("hip_left"), r = landmarks.find("hip_right");
  const auto middle = landmarks.find("mid_hip");
  const bool both = l != landmarks.end() && r != landmarks.end();
  hips_ = both || middle != landmarks.end();
  middle_ = both    ? Eigen::Vector3d(0.5 * (l->second.point + r->second.point))
            : hips_ ? middle->second.point
                    : Eigen::Vector3d::Zero();
  root_ = !hips_ && landmarks.contains("shoulder_left") ? upper_trunk : lower_trunk;
  left_ = trunk_axes(landmarks).col(0);
  for (std::size_t label = 1; label < parts.size(); ++label)
    if (const Cut* cut = by_distal_[label]; cut && !is_axial(cut->distal) && is_axial(cut->proximal))
      limbs_.push_back({cut, cut->proximal == lower_trunk, parts[label].joint.ends_with("_left")});
}

const Cut* PartPlanes::cut_to(int distal) const { return by_distal_[static_cast<std::size_t>(distal)]; }

bool PartPlanes::parts_off(int distal) const {
  return convention_ == Convention::bone ? joint_seen_[static_cast<std::size_t>(distal)]
                                         : cut_to(distal) != nullptr;
}

double PartPlanes::distance(int label, const Eigen::Vector3d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Cut& cut : cuts_) {
    const bool axial = is_axial(label) && (is_axial(cut.proximal) || is_axial(cut.distal));
    if (axial || cut.proximal == label || cut.distal == label)
      nearest = std::min(nearest, std::abs((point - cut.point).dot(cut.normal)));
  }
  return nearest;
}

int PartPlanes::axial_part(const Eigen::Vector3d& point) const {
  // parts from bottom to top; distal[n] names the plane between upwards[n] and upwards[n + 1], since the tree
  // grows up from the lower trunk
  const std::array<int, 4> upwards{lower_trunk, middle_trunk, upper_trunk, head};
  const std::array<int, 3> distal{middle_trunk, upper_trunk, head};
  int part = 0;
  bool known = false;
  for (std::size_t n = 0; n < 3; ++n) {
    const Cut* cut = cut_to(distal[n]);
    if (!cut) continue;
    if (!known) part = upwards[n], known = true;
    if (beyond(*cut, point)) part = upwards[n + 1];
  }
  return known ? part : root_;
}

// whether a plane lies between two parts among head and the three trunk parts
bool PartPlanes::separates(int a, int b) const {
  const auto height = [](int label) {
    return label == head ? 3 : label == upper_trunk ? 2 : label == middle_trunk ? 1 : 0;
  };
  const std::array<int, 3> distal{middle_trunk, upper_trunk, head};
  for (int n = std::min(height(a), height(b)); n < std::max(height(a), height(b)); ++n)
    if (cut_to(distal[static_cast<std::size_t>(n)])) return true;
  return false;
}

int PartPlanes::part(int owner, const Eigen::Vector3d& point) const {
  if (owner == 0 || convention_ == Convention::bone) return owner;
  if (is_axial(owner)) {
    for (const auto& [cut, at_hip, left] : limbs_) {
      if (!beyond(*cut, point) || (point - cut->point).norm() > cut->reach) continue;
      // below the crotch a point lies beyond both hips' planes: the midsagittal plane decides
      if (hips_ && at_hip && ((point - middle_).dot(left_) > 0) != left) continue;
      if (at_hip && axial_part(point) != lower_trunk) continue;
      return cut->distal;
    }
    const int level = axial_part(point);
    return separates(owner, level) ? level : owner;
  }
  if (const Cut* cut = cut_to(owner);
      cut && !beyond(*cut, point) && (point - cut->point).norm() <= cut->reach)
    return is_axial(cut->proximal) ? axial_part(point) : cut->proximal;
  for (const Cut& cut : cuts_)
    if (cut.proximal == owner && beyond(cut, point) && (point - cut.point).norm() <= cut.reach)
      return cut.distal;
  return owner;
}

}  // namespace borelli
