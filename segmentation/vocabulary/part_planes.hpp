// Applies the convention's planes: which part a point belongs to, given the part whose flesh it is.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "segmentation/vocabulary/cuts.hpp"

namespace borelli {

class PartPlanes {
 public:
  /// Makes the planes of cuts.hpp for these landmarks. Parts of head and trunk without a plane between them
  /// get one label, see axial_part. `change` may shift each plane, e.g. to measure sensitivity.
  explicit PartPlanes(const Landmarks& landmarks, Convention convention = Convention::deleva1996,
                      const std::function<void(Cut&)>& change = {});

  /// The part of a point (patient frame, mm) whose flesh belongs to `owner`. A plane moves the point only
  /// across its own joint and within its reach. Without planes (`bone`) the answer is `owner`.
  int part(int owner, const Eigen::Vector3d& point) const;

  /// The part among head and the three trunk parts at the level of a point (patient frame, mm). If a plane
  /// between two of them is missing, the part nearer the known planes gets both.
  int axial_part(const Eigen::Vector3d& point) const;

  /// Signed distance of a point to the left of mid_hip, mm (right: negative). Without hips: of the scan's
  /// origin.
  double side(const Eigen::Vector3d& point) const { return (point - middle_).dot(left_); }

  /// Whether something separates the part from its parent: a plane, or with `bone` the joint's landmark.
  bool parts_off(int distal) const;

  /// Distance from a point to the nearest plane that bounds the part, mm; infinite if there is none. For head
  /// and trunk parts, any plane that bounds one of them counts.
  double distance(int label, const Eigen::Vector3d& point) const;

  Convention convention() const { return convention_; }
  const std::vector<Cut>& cuts() const { return cuts_; }

 private:
  const Cut* cut_to(int distal) const;
  bool separates(int a, int b) const;

  Convention convention_;
  std::vector<Cut> cuts_;
  std::array<bool, 17> joint_seen_{};
  std::array<const Cut*, 17> by_distal_{};
  struct Limb {
    const Cut* cut;  // from the trunk
    bool at_hip, left;
  };
  std::vector<Limb> limbs_;
  Eigen::Vector3d middle_, left_;
  bool hips_ = false;
  int root_ = 0;  // the trunk's part if no plane cuts the trunk
};

}  // namespace borelli
