// Puts solids into the phantom, each into what it is nested in. Internal to the phantom's own files.
#pragma once

#include <string>
#include <vector>

#include "samples/phantom.hpp"
#include "samples/phantom_plan.hpp"

namespace borelli {

namespace tissue {
extern const PhantomTissue air, lung, fat, brain, blood, muscle, liver, cartilage, spongiosa, cortex, metal,
    table, blanket;
}

/// What lies on a plane through a point and to that side of it to which its normal does not show.
inline HalfSpace below(const Eigen::Vector3d& normal, const Eigen::Vector3d& point) {
  return {normal.normalized(), normal.normalized().dot(point)};
}
/// The other side.
inline HalfSpace above(const Eigen::Vector3d& normal, const Eigen::Vector3d& point) {
  return below(-normal, point);
}

struct PhantomBuilder {
  BodyPlan plan;
  DensityCurve curve;
  double girth = 1;
  std::string metal_hip;
  std::vector<PhantomSolid> solids;
  std::vector<Eigen::Matrix4d> moments;  ///< of each solid's shape, as EllipticStack::moments

  /// Adds a solid of a part with nothing around it.
  int add(std::string name, const EllipticStack& shape, const PhantomTissue& tissue, int part);
  /// Nests a solid in each of `hosts` (indices) that it reaches, cut where the host is cut: a bone that
  /// crosses from one segment into the next becomes two solids that meet in the cut plane. Answers their
  /// indices. Negative hosts are none.
  std::vector<int> nest(const std::string& name, const EllipticStack& shape, const PhantomTissue& tissue,
                        const std::vector<int>& hosts);
  /// A bone: cortical shell, spongiosa within.
  std::vector<int> bone(const std::string& name, const EllipticStack& shape, double cortex,
                        const std::vector<int>& hosts);
  /// A landmark that a bone's own shape gives, patient frame at nominal stature, mm.
  void mark(const std::string& name, const Eigen::Vector3d& point);
};

/// The muscle of each part, by index; bones are nested in it. The hand has a palm and fingers, thumb first;
/// the thigh has a flank beside the pelvis, which does not move with the leg.
struct Flesh {
  int head, upper_trunk, middle_trunk, lower_trunk;
  int upper_trunk_low = -1;                  ///< below the shoulders' reach, where that counts
  std::array<int, 2> upper_arm_low{-1, -1};  ///< likewise
  std::array<int, 2> upper_arm, forearm, palm, flank, thigh, shank, foot;
  std::array<std::array<int, 5>, 2> finger;
};

Flesh add_flesh(PhantomBuilder& builder);
void add_organs(PhantomBuilder& builder, const Flesh& flesh);
void add_axial_bones(PhantomBuilder& builder, const Flesh& flesh);
void add_arm_bones(PhantomBuilder& builder, const Flesh& flesh, int side);
void add_leg_bones(PhantomBuilder& builder, const Flesh& flesh, int side);

/// A finger's base and length in the hand's frame, and its radius; thumb first, then index to little finger.
struct Finger {
  Eigen::Vector3d base, direction;
  double length, radius;
};
std::array<Finger, 5> fingers(const Proportions& size);

}  // namespace borelli
