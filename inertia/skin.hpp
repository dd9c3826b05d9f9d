// The skin's mixed voxels: those that hold part body, part air, and lie outside a label map.
//
// A label map ends where a voxel is less than half body; what the voxels beyond hold is then lost (of a
// blurred hand at 2 mm, 2 %), and what the voxels within lack is not made up for. So each outside voxel near
// the body is given the label of the part beside it, and counts with its density. Air counts nothing by that,
// on average: see `BelowAir::straight` in density.hpp. A table or a blanket that touches the skin does count,
// within that reach.
#pragma once

#include <array>

#include "error/error.hpp"
#include "inertia/moments.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// The label map with the outside voxels along the body's border added to the part nearest to each: one voxel
/// along each axis for the voxel's own extent, and further ones as far as the scanner's blur carries,
/// `blur_reach` in mm (three standard deviations of its point spread; 3 mm is that of a usual CT kernel for
/// soft tissue).
LabelMap grow_skin(const LabelMap& labels, double blur_reach = 2);

/// Volumes in voxels, per label.
struct SkinVolumes {
  std::array<double, 256> all{};   ///< with the skin's mixed voxels, each by how much of it is body
  std::array<double, 256> skin{};  ///< of that, what the skin's mixed voxels hold
};

/// What labels hold where voxels are averages. A label map cut at half loses the outer half of what blur and
/// voxels smear; so the voxels about its border, as far inwards as grow_skin goes outwards, count with their
/// weight over that of the tissue next within (the mean of the layer there, label by label). `weights`: with
/// BelowAir::straight; `grown`: moments of grow_skin's labels by them. Fails as label_moments does.
Result<SkinVolumes> volumes_with_skin(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                      const GreyWeights& weights, const LabelMoments& grown,
                                      double blur_reach = 2, int threads = 0);

/// Are the voxels at the skin mixtures, as a scanner makes them, or points, as in a drawn volume? The share
/// of the outside voxels with a neighbour in the body along an axis whose weight is 20 to 80 % of that of
/// water (1000 kg/m^3): nearly none among points, where noise does not reach 20 %, and about 30 % among
/// averages with a label map cut at half. Fails as label_moments does.
Result<double> mixed_share(const LabelMap& labels, const Volume<std::int16_t>& grey,
                           const GreyWeights& weights);

/// What `mixed_share` means: averages from a tenth on.
inline Sampling sampling_by(double mixed) { return mixed > 0.1 ? Sampling::averages : Sampling::points; }

}  // namespace borelli
