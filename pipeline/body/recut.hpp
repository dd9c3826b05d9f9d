// Cuts a labelled body again by slightly moved planes, on a sample of its voxels. Finds what moves from part
// to part, cheaply enough for many repetitions.
#pragma once

#include <array>
#include <vector>

#include "inertia/inertial.hpp"
#include "inertia/moments.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Gain of a part over patient axes, in metres: volume is the integral of 1; mass, first and second are the
/// integrals of the density times 1, p and p p^T, where p = (x, y, z).
struct PartGain {
  double volume = 0, mass = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// A sampled voxel of a labelled body.
struct CutSample {
  Eigen::Vector3d point;  ///< mm
  double volume, mass;    ///< m^3, kg
  std::uint8_t label, nominal;
};

class Recut {
 public:
  /// `weights` as in moments.hpp; `nominal`: the planes that cut the labels; `deviation`, mm: how far planes
  /// may move. Only voxels within six deviations of a plane matter and are kept. About 400 000 voxels are
  /// sampled, each at a random place within its box, so that gains vary smoothly as planes along the grid
  /// move.
  Recut(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
        const PartPlanes& nominal, double deviation);

  /// By label: parts cut by `planes` minus parts cut by the nominal planes.
  std::array<PartGain, 17> gains(const PartPlanes& planes) const;

 private:
  std::vector<CutSample> samples_;
};

/// The same for parts without cut planes (convention `bone`). The borders at neck, T12/L1 and L5/S1 move
/// along the body with their discs, as far as the flesh moves with them.
class MovedDiscs {
 public:
  /// Never fails; without discs nothing moves.
  MovedDiscs(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
             const Landmarks& landmarks);

  /// By label: gains when the discs move from their nominal places to those in `moved`.
  std::array<PartGain, 17> gains(const Landmarks& moved) const;

 private:
  const LabelMap& labels_;
  Landmarks discs_;
  Eigen::Vector3d up_;
  std::vector<CutSample> samples_;
};

/// Adds a gain to a part.
Inertial with_gain(const Inertial& part, const PartGain& gain);

}  // namespace borelli
