#include "pipeline/recordings/bvh_motion.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <numbers>

#include "process/memory.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Poses frame by frame, with what is the same in all frames worked out once.
class BvhPoser {
 public:
  BvhPoser(const BvhMotion& motion, BvhPositions positions)
      : motion_(motion), first_(motion.first_channels()) {
    for (std::size_t joint = 0; joint < motion.joints.size(); ++joint)
      replaces_.push_back(positions == BvhPositions::replaced ||
                          (positions == BvhPositions::by_data && replaces_offset(motion, joint)));
  }

  std::vector<Pose> at(Eigen::Index frame) const {
    std::vector<Pose> X_W;
    X_W.reserve(motion_.joints.size());
    for (std::size_t joint = 0; joint < motion_.joints.size(); ++joint) {
      const int parent = motion_.joints[joint].parent;
      const Pose X_P = in_parent(joint, frame);
      X_W.push_back(parent < 0 ? X_P : X_W[static_cast<std::size_t>(parent)] * X_P);
    }
    return X_W;
  }

 private:
  Pose in_parent(std::size_t index, Eigen::Index frame) const {
    const BvhJoint& joint = motion_.joints[index];
    Pose X{Eigen::Matrix3d::Identity(), joint.offset};
    Eigen::Index column = first_[index];
    for (const BvhChannel& channel : joint.channels) {
      const double value = motion_.values(frame, column++);
      if (channel.rotation)
        X.R *= rotation_about(Vector3d::Unit(channel.axis), value * std::numbers::pi / 180);
      else
        X.p[channel.axis] = value + (replaces_[index] ? 0 : joint.offset[channel.axis]);
    }
    return X;
  }

  const BvhMotion& motion_;
  std::vector<Eigen::Index> first_;
  std::vector<bool> replaces_;
};

}  // namespace

bool replaces_offset(const BvhMotion& motion, std::size_t joint) {
  const BvhJoint& of = motion.joints[joint];
  if (motion.values.rows() == 0) return false;
  Eigen::Index column = 0;
  for (std::size_t before = 0; before < joint; ++before) column += std::ssize(motion.joints[before].channels);
  double along = 0, length = 0;
  for (const BvhChannel& channel : of.channels) {
    const double offset = of.offset[channel.axis];
    if (!channel.rotation) along += motion.values.col(column).mean() * offset, length += offset * offset;
    ++column;
  }
  return along > length / 2;
}

std::vector<Pose> bvh_poses(const BvhMotion& motion, Eigen::Index frame, BvhPositions positions) {
  return BvhPoser(motion, positions).at(frame);
}

std::vector<Pose> bvh_rest_poses(const BvhMotion& motion) {
  std::vector<Pose> X_W;
  for (const BvhJoint& joint : motion.joints) {
    Pose X{Eigen::Matrix3d::Identity(), joint.offset};
    if (joint.parent >= 0) X.p += X_W[static_cast<std::size_t>(joint.parent)].p;
    X_W.push_back(X);
  }
  return X_W;
}

std::optional<double> guessed_bvh_unit(const BvhMotion& motion) {
  const std::vector<Pose> rest = bvh_rest_poses(motion);
  if (rest.empty()) return std::nullopt;
  Vector3d low = rest[0].p, high = rest[0].p;
  for (const Pose& X : rest) low = low.cwiseMin(X.p), high = high.cwiseMax(X.p);
  const double height = (high - low).maxCoeff();
  for (const double units : {1., 10., 100., 1000.})
    if (height >= 0.3 * units && height < 3 * units) return 1 / units;
  return std::nullopt;
}

Result<MarkerMotion> bvh_markers(const BvhMotion& motion, double metres, const std::string& file,
                                 BvhPositions positions) {
  const Eigen::Index frames = motion.values.rows();
  if (frames == 0) return failure(file, "contains no frame of motion");
  if (!(metres > 0) || !std::isfinite(metres))
    return bad_use(file, fmt::format("has a unit of {:g} m, expected a positive number", metres));
  const double bytes = 24.0 * static_cast<double>(frames) * static_cast<double>(motion.joints.size());
  if (auto fits = admit_memory(file, "its joint centres", bytes); !fits) return tl::unexpected(fits.error());
  MarkerMotion out;
  for (const BvhJoint& joint : motion.joints) out.names.push_back(joint.name);
  const BvhPoser poser(motion, positions);
  for (Eigen::Index frame = 0; frame < frames; ++frame) {
    const std::vector<Pose> X_W = poser.at(frame);
    Eigen::Matrix3Xd places(3, std::ssize(X_W));
    for (std::size_t joint = 0; joint < X_W.size(); ++joint)
      places.col(static_cast<Eigen::Index>(joint)) = X_W[joint].p * metres;
    if (!places.allFinite())
      return failure(file, fmt::format("places a joint impossibly far away in frame {}", frame + 1));
    out.times.push_back(static_cast<double>(frame) * motion.frame_time);
    out.frames.push_back(std::move(places));
  }
  if (!std::isfinite(out.times.back()) ||
      (frames > 1 && !(out.times.back() > out.times[out.times.size() - 2])))
    return failure(file, fmt::format("has the frame time {:g} s, too short to tell its frames apart",
                                     motion.frame_time));
  return out;
}

}  // namespace borelli
