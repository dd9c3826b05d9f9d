// Whether a pair of balls can be a body's hips or its shoulders: what the scan itself shows about them.
#pragma once

#include <array>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/spheres.hpp"

namespace borelli {

/// A chest has shoulders that look like hips and hips have tubers that look like heads, so a pair of round
/// bones alone proves nothing. All points patient frame, mm.
class HeadsInBody {
 public:
  explicit HeadsInBody(const Anatomy& anatomy);

  /// The places of two balls, left and right, against what must lie about hips: the sacrum in view behind and
  /// above, thick flesh between, and no lung up to a hand's length above.
  bool near_hips(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
  /// Balls as measured against what femoral heads stand in: no vertebra but coccyx and
  /// symphysis at most between them, and a femur below each (see on_femur).
  bool are_hips(const FoundSphere& left, const FoundSphere& right) const;
  /// The same where heads may be cut by the scan's lower end, from which no femur need lead on.
  bool may_be_hips(const FoundSphere& left, const FoundSphere& right) const;
  /// Whether the scan ends within a head, or so close below it that no femur can be followed; or would, were
  /// the head lower by `off` mm.
  bool cuts(const FoundSphere& ball, double off = 0) const;
  /// The same of the scan's upper end: what is left of a head then passes for a smaller one, lower down.
  bool cuts_from_above(const FoundSphere& ball, double near) const;
  /// As Trunk::lungs.
  std::array<double, 2> lungs() const;
  /// Between and below shoulders lie the tops of the lungs, which narrow upwards there and end soon above;
  /// what roofs the heads must be in view. Legs have no lungs, and ribs no lung that ends.
  bool at_shoulders(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
  /// Whether the scan's side cuts the trunk beside `middle` (mm, patient x), so that but one `side` of the
  /// body is in view: body meets the scan's edge there over more than a limb does.
  bool cut_beside(double middle, int side) const;
  /// Whether the lungs begin a hand's breadth over a level (mm, patient z) or higher, as over hips.
  bool below_lungs(double z) const;
  /// Over a hip and its ilium follows a flank, where no bone is; over vertebrae and sacrum the column.
  bool below_flank(const Eigen::Vector3d& hip) const;
  /// Of a shoulder alone: the lung's top beside and below, none above.
  bool at_shoulder(const Eigen::Vector3d& head) const;

  /// Heads are bone through and through (but for what thin scans leave unfilled); of a ball that ribs or a
  /// sacrum's edges agree on half is not.
  bool solid(const FoundSphere& ball) const;
  /// From now on every ball passes for solid: about a child's heads the balls of an adult's size hold more
  /// than bone, and tell its size all the same.
  void allow_hollow() { hollow_ = true; }
  /// From a femoral head bone leads straight outwards and down to the shaft, or to where the scan ends below
  /// or beside; from a tuber, a socket or an iliac wing it leads there by a detour or not at all. The head
  /// itself must be in view whole.
  bool on_femur(const FoundSphere& ball, int side) const;

 private:
  const Anatomy& anatomy_;
  bool hollow_ = false;
  std::vector<double> lung_;   // ml within each slice of the work grid
  double low_ = 0, high_ = 0;  // lowest and highest level with body in view

  /// What on_femur was asked, many pairs having a ball in common, and its answer.
  struct Asked {
    Eigen::Vector3d centre;
    double radius;
    int side;
    bool leads;
  };
  mutable std::vector<Asked> asked_;
  /// Of either side, once it was asked about: mm^2 of body in each sagittal plane of the work grid whose next
  /// one inwards the scan does not show.
  mutable std::array<std::vector<double>, 2> edge_;

  bool femur_leads_on(const FoundSphere& ball, int side) const;
  bool vertebra_between(const FoundSphere& left, const FoundSphere& right) const;
  double below(const FoundSphere& ball) const;  // mm in view below a centre
  double lung_between(double low, double high) const;
};

}  // namespace borelli
