// The convention's planes at work: which part a place belongs to, given the part that owns its flesh.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "segmentation/vocabulary/cuts.hpp"

namespace borelli {

class PartPlanes {
 public:
  /// Planes of cuts.hpp for the landmarks at hand. Head and trunk parts that no plane parts belong together:
  /// to the lowest part in view above a missing plane, see axial_part.
  /// `change` may shift each plane a little, e.g. to see what that does.
  explicit PartPlanes(const Landmarks& landmarks, Convention convention = Convention::deleva1996,
                      const std::function<void(Cut&)>& change = {});

  /// The part of a place (patient mm) whose flesh belongs to `owner`: a plane moves it across its joint only,
  /// and only within the plane's reach. Without planes (`bone`) it is the owner's.
  int part(int owner, const Eigen::Vector3d& point) const;

  /// Which of head and trunk's three parts holds a level. Where a plane between two of them is missing, the
  /// part nearer the known planes has both.
  int axial_part(const Eigen::Vector3d& point) const;

  /// How far left of the hips' middle a place is, mm (right: negative); without hips, of the scan's origin.
  double side(const Eigen::Vector3d& point) const { return (point - middle_).dot(left_); }

  /// Whether the part is told from the one that it hangs on: by a plane, with `bone` by the joint between
  /// them.
  bool parts_off(int distal) const;

  /// How far the nearest plane is that bounds the part (of head and trunk: any that bounds one of them), mm;
  /// infinite where there is none.
  double distance(int label, const Eigen::Vector3d& point) const;

  Convention convention() const { return convention_; }
  const std::vector<Cut>& cuts() const { return cuts_; }

 private:
  const Cut* cut_to(int distal) const;
  bool told_apart(int a, int b) const;

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
  int root_ = 0;  // where no plane parts the trunk: its part by the joints in view
};

}  // namespace borelli
