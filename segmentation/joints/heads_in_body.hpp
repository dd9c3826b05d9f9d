// Tests whether a pair of spheres can be a body's hips or shoulders, from the anatomy around them.
#pragma once

#include <array>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/spheres.hpp"

namespace borelli {

/// A chest has shoulders that resemble hips, and hips have ischial tubers that resemble heads: a pair of
/// round bones alone proves nothing. All points in the patient frame (LPS), mm.
class HeadsInBody {
 public:
  explicit HeadsInBody(const Anatomy& anatomy);

  /// True if two candidate centres can be hips: their midpoint lies deep in flesh, and no lung lies within
  /// 120 mm above it.
  bool deep_below_lungs(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
  /// The same, and sacrum or lumbar vertebrae are in view behind and above.
  bool near_hips(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
  /// True if both measured spheres can be femoral heads: solid, no vertebra between them (coccyx and
  /// symphysis may be), and a femur leads on from each (see on_femur).
  bool are_hips(const FoundSphere& left, const FoundSphere& right) const;
  /// The same, but a head that the scan's lower end cuts needs no femur.
  bool may_be_hips(const FoundSphere& left, const FoundSphere& right) const;
  /// True if the scan's lower end cuts the head, or lies so close below it that no femur can be followed.
  /// `off`: test as if the head were that much lower, mm.
  bool cuts(const FoundSphere& ball, double off = 0) const;
  /// True if the scan's upper end is less than `near` mm above the centre. A head cut there looks smaller and
  /// lower.
  bool cuts_from_above(const FoundSphere& ball, double near) const;
  /// See Trunk::lungs.
  std::array<double, 2> lungs() const;
  /// True if the surroundings of two candidate centres fit shoulders: the tops of the lungs lie between and
  /// below them, taper upwards and end just above. The region above the heads must be in view. Legs have no
  /// lung, and beside the ribs the lung continues.
  bool at_shoulders(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
  /// True if the scan's side cuts the trunk near the plane x = `middle` (mm, LPS), so that only `side` of the
  /// body is in view. The area of body cut there exceeds that of a limb.
  bool cut_beside(double middle, int side) const;
  /// True if less than 100 ml of lung lie below a level 120 mm above `z` (mm, LPS), as above hips.
  bool below_lungs(double z) const;
  /// True if no bone lies in the flank above a hip; false beside the vertebral column, as for vertebrae and
  /// sacrum.
  bool below_flank(const Eigen::Vector3d& hip) const;
  /// at_shoulders for a single head: lung within 20 to 60 mm below its level, none from 100 mm above it.
  bool at_shoulder(const Eigen::Vector3d& head) const;

  /// True if the sphere's core is filled with bone, as in a head (thin slices may leave some of the marrow
  /// unfilled). Spheres that fit ribs or the edges of a sacrum are at least half hollow.
  bool solid(const FoundSphere& ball) const;
  /// Lets every sphere pass `solid` from now on. On a child's head, spheres of adult size enclose more than
  /// bone, but still give the child's size.
  void allow_hollow() { hollow_ = true; }
  /// True if bone leads straight outwards and down from the head to the shaft, or to the scan's lower end or
  /// side. From a tuber, socket or iliac wing the path is a detour or does not exist. The head itself must be
  /// wholly in view.
  bool on_femur(const FoundSphere& ball, int side) const;

 private:
  const Anatomy& anatomy_;
  bool hollow_ = false;
  std::vector<double> lung_;   // ml in each slice of the work grid
  double low_ = 0, high_ = 0;  // lowest and highest level with body in view, mm (LPS z)

  /// Cached answer of on_femur; many pairs share a sphere.
  struct Asked {
    Eigen::Vector3d centre;
    double radius;
    int side;
    bool leads;
  };
  mutable std::vector<Asked> asked_;
  /// By side, filled on first use: area of body (mm^2) in each sagittal plane of the work grid that borders,
  /// on its inner side, on a voxel out of view.
  mutable std::array<std::vector<double>, 2> edge_;

  bool femur_leads_on(const FoundSphere& ball, int side) const;
  bool vertebra_between(const FoundSphere& left, const FoundSphere& right) const;
  double below(const FoundSphere& ball) const;  // mm in view below the centre
  double lung_between(double low, double high) const;
};

}  // namespace borelli
