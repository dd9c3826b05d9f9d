// Adds solids to the phantom, each nested in its host. Internal to the phantom's own files.
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

/// The half-space below a plane through a point, opposite to its normal.
inline HalfSpace below(const Eigen::Vector3d& normal, const Eigen::Vector3d& point) {
  return {normal.normalized(), normal.normalized().dot(point)};
}
/// The opposite half-space.
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

  /// Adds a root solid (nested in none) of a part.
  int add(std::string name, const EllipticStack& shape, const PhantomTissue& tissue, int part);
  /// Nests a solid in each of `hosts` (indices) that it reaches, with the host's cuts: a bone that crosses
  /// from one segment into the next becomes two solids that meet in the cut plane. Returns their indices.
  /// Ignores negative hosts.
  std::vector<int> nest(const std::string& name, const EllipticStack& shape, const PhantomTissue& tissue,
                        const std::vector<int>& hosts);
  /// A bone: cortical shell of thickness `cortex` (mm) around spongiosa.
  std::vector<int> bone(const std::string& name, const EllipticStack& shape, double cortex,
                        const std::vector<int>& hosts);
  /// Adds a landmark that follows from a bone's shape, patient frame at nominal stature, mm.
  void mark(const std::string& name, const Eigen::Vector3d& point);
};

/// Indices of each part's muscle, in which the bones are nested. The hand has a palm and fingers, thumb
/// first. The thigh has a flank beside the pelvis, which does not move with the leg.
struct Flesh {
  int head, upper_trunk, middle_trunk, lower_trunk;
  int upper_trunk_low = -1;                  ///< the part below the shoulders' planes, if it exists; else -1
  std::array<int, 2> upper_arm_low{-1, -1};  ///< the same
  std::array<int, 2> upper_arm, forearm, palm, flank, thigh, shank, foot;
  std::array<std::array<int, 5>, 2> finger;
};

Flesh add_flesh(PhantomBuilder& builder);
void add_organs(PhantomBuilder& builder, const Flesh& flesh);
void add_axial_bones(PhantomBuilder& builder, const Flesh& flesh);
void add_arm_bones(PhantomBuilder& builder, const Flesh& flesh, int side);
void add_leg_bones(PhantomBuilder& builder, const Flesh& flesh, int side);

/// A finger's base, direction and length in the hand's frame, and its radius; thumb first, then index to
/// little finger.
struct Finger {
  Eigen::Vector3d base, direction;
  double length, radius;
};
std::array<Finger, 5> fingers(const Proportions& size);

}  // namespace borelli
