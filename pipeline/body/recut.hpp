// A labelled body cut anew by planes that lie a little otherwise, on a sample of its voxels: what that moves
// from part to part, cheaply enough to be done many times.
#pragma once

#include <array>
#include <vector>

#include "inertia/inertial.hpp"
#include "inertia/moments.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/part_planes.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// What a part gains, as integrals over patient axes in metres: of density 1, of (x, y, z), of (x, y, z)(x,
/// y, z)^T.
struct PartGain {
  double volume = 0, mass = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// A voxel's share of a labelled body, for those that are looked at.
struct CutSample {
  Eigen::Vector3d point;  ///< mm
  double volume, mass;    ///< m^3, kg
  std::uint8_t label, nominal;
};

class Recut {
 public:
  /// `weights` as of moments.hpp; `nominal` the planes by which the labels were cut; `deviation` mm, how far
  /// planes may move: only voxels within six of it matter and are kept. Some 400 000 voxels are looked at,
  /// each at a place drawn within its box, so that planes along the grid move through them smoothly.
  Recut(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
        const PartPlanes& nominal, double deviation);

  /// By label: the difference between the parts by `planes` and those by the nominal ones.
  std::array<PartGain, 17> gains(const PartPlanes& planes) const;

 private:
  std::vector<CutSample> samples_;
};

/// The same of parts that no planes cut (convention `bone`): the borders at neck, T12/L1 and L5/S1 moved
/// along the body with their discs, as far as flesh goes with them.
class MovedDiscs {
 public:
  /// Errors: none; without discs nothing moves.
  MovedDiscs(const LabelMap& labels, const GreyVolume& volume, const GreyWeights& weights,
             const Landmarks& landmarks);

  /// By label: what the discs' places in `moved` in place of the nominal ones make of it.
  std::array<PartGain, 17> gains(const Landmarks& moved) const;

 private:
  const LabelMap& labels_;
  Landmarks discs_;
  Eigen::Vector3d up_;
  std::vector<CutSample> samples_;
};

/// The part with its gain.
Inertial with_gain(const Inertial& part, const PartGain& gain);

}  // namespace borelli
