// How tissue moves with joints: the share of every joint's motion at each corner of a body's voxels.
//
// With path lengths d_p and d_c (mm) through tissue to the bones before and behind a joint, the share is the
// smooth step of 1/2 + (d_p - d_c) / (2 min(W, d_p + d_c)): 0 on the bone before, 1 on the bone behind, and
// from 0 to 1 over W mm of the limb elsewhere. The spine's two joints share by height: from the pelvis' crest
// to T12/L1, and from there to 60 mm above the xiphion; arms move with the upper trunk, legs with the pelvis.
//
// Voxels that touch share their corners, except across contacts (`may_touch`): there each has its own, so
// that skin tears. A corner at a bone moves as the bone does, so bones stay rigid.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace borelli::suite {

struct LabelledBody;

/// The joints, those nearer the root first.
inline constexpr std::array<std::string_view, 15> body_joints{
    "spine_lower", "spine_upper", "neck",       "shoulder_left", "shoulder_right",
    "elbow_left",  "elbow_right", "wrist_left", "wrist_right",   "hip_left",
    "hip_right",   "knee_left",   "knee_right", "ankle_left",    "ankle_right"};
inline constexpr std::size_t n_joints = body_joints.size();

/// Index in body_joints; n_joints for any other name.
constexpr std::size_t joint_index(std::string_view name) {
  for (std::size_t j = 0; j < n_joints; ++j)
    if (body_joints[j] == name) return j;
  return n_joints;
}

/// Shares of all joints, in units of 1/65535.
using Shares = std::array<std::uint16_t, n_joints>;
inline constexpr double share_unit = 1.0 / 65535;

struct BodyLattice {
  std::vector<Eigen::Vector3f> rest;                  ///< by corner, mm
  std::vector<Shares> share;                          ///< by corner
  std::vector<float> lift;                            ///< by corner: share of the skin's motion, 0 to 1
  std::vector<std::array<std::uint32_t, 8>> corners;  ///< by voxel; bits 0, 1, 2: upper along i, j, k
  std::vector<Shares> voxel_share;                    ///< by voxel
  std::vector<float> voxel_lift;                      ///< by voxel
};

/// Builds the lattice. `lift` is 0 on bone and 60 mm below the skin, and 1 at skin at least 30 mm from bone.
BodyLattice lattice_of(const LabelledBody& body);

}  // namespace borelli::suite
