// The broad end of a limb's bone at a joint: its centre and its sides.
#pragma once

#include <optional>
#include <string>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/bent_joints.hpp"
#include "segmentation/joints/limbs.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// Unit direction from the right to the left hip, or shoulder; x if neither pair was found.
Eigen::Vector3d body_left(const Trunk& trunk);

/// One limb in its body.
struct LimbInBody {
  const Anatomy& anatomy;
  const Trunk& trunk;
  const Limbs& limbs;
  Limb limb;
  int side;
  const LimbPath& path;
  std::string suffix = side_suffix(side);  ///< of its landmarks' names
  double scale = trunk.scale;              ///< the body's size, see Trunk
  Eigen::Vector3d left = body_left(trunk);
};

/// A section of a limb's bone perpendicular to a direction; mm, LPS.
struct BoneSection {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mean of its bone, projected onto its plane
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  ///< midway between its ends along `wide`
  Eigen::Vector3d wide = Eigen::Vector3d::UnitX();   ///< unit direction of largest extent
  double ratio = 1;                                  ///< of its standard deviations, largest to smallest
};

/// Section through `point`, perpendicular to the unit direction `along`, from the bone within `half` mm of its
/// plane and `reach` mm of the point. Without bone there, centre and middle are the point.
BoneSection section_of(const LimbInBody& limb, const Eigen::Vector3d& point, const Eigen::Vector3d& along,
                       double half, double reach);

/// A bone's broad end: the centre on the joint's axis, and the axis' ends at the bone's sides; mm, LPS.
struct JointEnd {
  Eigen::Vector3d centre, medial, lateral;
  double radius = 0;
  double deviation = 0;
  bool measured = false;  ///< on a cylinder that the bone's edges agree on
};

/// How a bone's end is searched, mm.
struct JointCylinder {
  double reach, least, most, search;  ///< see fit_hinge
  double inner, outer;                ///< range along the axis in which the bone's sides are searched
  double agree;  ///< fraction of rays that must agree on the cylinder; over 1: outlines only
  double faces;  ///< 1: the joint's surface faces down the limb; 0: bone continues on all sides of it
  double above;  ///< mm up the limb; the section there is centred on the joint and widest along its axis
  bool farthest = false;  ///< see fit_hinge: on large voxels, the cylinder farthest down the limb
  double along_left = 0;  ///< least cosine between the axis and the body's left
};

/// Finds the end near `point` of a bone along the unit direction `along`. `bent`: gives centre and axis if the
/// outlines of the next bone lie beside this one's.
JointEnd joint_end(const LimbInBody& limb, const Eigen::Vector3d& point, const Eigen::Vector3d& along,
                   const JointCylinder& shape, const std::optional<BentJoint>& bent = std::nullopt);

}  // namespace borelli
