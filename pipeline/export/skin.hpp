// The body as one closed skin that bends with its parts: rest mesh, bones, weights.
//
// A viewer moves each point by linear blending (glTF 2.0, section 3.7.3): p = sum_b w_b X_WB X_BW(rest) p.
// Blending two poses a rotation of theta apart leaves cos(theta / 2) of a limb's radius, so bones stand
// between a part and its parent that take shares of the joint's rotation. With n intervals cos(theta / 2n) is
// left. The rotation is split into twist about the segment's axis and swing (skin_pose.hpp). The swing is
// spread over a zone around the joint, the twist along the longer of the two segments at the joint.
//
// Weights depend on the length of the path through the flesh from the cut between the two parts
// (skin_weights.hpp). Paths do not cross air nor skin that touches skin, so a hand that lies on the thigh
// moves with its forearm alone.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/export/mesh.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// A part of the body and the joint to its parent.
struct SkinJoint {
  std::string part;                       ///< the name of its label
  std::string parent;                     ///< empty: none
  std::optional<Eigen::Vector3d> centre;  ///< p_WJ in the scan's pose, m; empty: moves with its parent
  bool twists = true;                     ///< false: a hinge across the limb, such as elbow and knee
};

/// The joints of a label map's parts (segmentation/labelling/segments.hpp) at their landmarks. Knees and
/// elbows are hinges, as in skeleton.hpp.
std::vector<SkinJoint> skin_joints(const LabelMap& labels, const Landmarks& landmarks);

struct SkinOptions {
  double tolerance = 0.001;  ///< of the mesh, m: MeshOptions::tolerance
  int helpers = 3;           ///< bones between a part and its parent, for the swing and for the twist
  double step = 0.004;  ///< of the grid that paths through the flesh follow, m; never finer than the labels
  int threads = 0;      ///< 0: as many as the machine has; the skin does not depend on it
};

/// Where a joint's rotation is spread.
enum class TwistAlong { zone, part, parent };

/// A part in the skin, with its joint.
struct SkinPart {
  std::string name;
  int parent = -1;         ///< index of a part before this one; -1: none
  bool has_joint = false;  ///< else it moves with its parent, unless it has a pose of its own and no parent
  Eigen::Vector3d centre{0, 0, 0};  ///< p_WJ in the scan's pose, m
  Eigen::Vector3d axis{0, 0, 1};  ///< unit vector that the joint twists about, world axes in the scan's pose
  TwistAlong twist = TwistAlong::zone;
  double half_thickness = 0;  ///< m: radius of the largest ball at the joint within the two parts
  Pose X_WS;                  ///< the part's frame in the scan's pose
};

/// A frame that points follow. Bone i < #parts is part i; the others are helpers.
struct SkinBone {
  std::string name;
  std::size_t part = 0;         ///< whose joint it takes shares of
  double swing = 1, twist = 1;  ///< shares, 0 (the parent's pose) to 1 (the part's)
};

struct Skin {
  Mesh mesh;  ///< closed, in the scan's pose
  std::vector<SkinPart> parts;
  std::vector<SkinBone> bones;
  std::vector<std::array<std::uint16_t, 4>>
      bones_of;                               ///< #points by 4, indices into bones; 0 where weight is 0
  std::vector<std::array<float, 4>> weights;  ///< #points by 4, descending, sum 1
};

/// The skin of all voxels that have a label. `X_WS`: the parts' frames in the scan's pose (scan_poses); a
/// part without one has the world's axes at its joint. Errors: no voxels; a label without a joint in
/// `joints`; a parent that comes later than its part; two joints of one part; no memory.
Result<Skin> skin_of(const LabelMap& labels, const std::vector<SkinJoint>& joints, const ScanPoses& X_WS,
                     const SkinOptions& options = {});

}  // namespace borelli
