// The skin's mixed voxels: partly body, partly air, and outside the label map.
//
// A label map ends where a voxel is less than half body. The body in the voxels beyond is then lost (2 % of a
// blurred hand at 2 mm), and the air in the voxels within does not compensate. So each outside voxel near the
// body gets the label of the part beside it and counts with its density. Air then adds nothing on average:
// see `BelowAir::straight` in density.hpp. A table or blanket within that reach of the skin does count.
#pragma once

#include <array>

#include "error/error.hpp"
#include "inertia/moments.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// The label map with outside voxels along the border added to the nearest part. It grows by one voxel along
/// each axis for the voxel's own extent, and by `blur_reach` mm for the scanner's blur. `blur_reach` is three
/// standard deviations of the point spread function (3 mm for a usual CT kernel for soft tissue).
LabelMap grow_skin(const LabelMap& labels, double blur_reach = 2);

/// Volumes in voxels, per label.
struct SkinVolumes {
  std::array<double, 256> all{};   ///< with the skin's mixed voxels, each by its share of body
  std::array<double, 256> skin{};  ///< the share of `all` in the skin's mixed voxels
};

/// Volumes of labels if voxels are averages. A label map cut at half loses the outer half of the region
/// smeared by blur and voxels. So the voxels about its border, as far inwards as grow_skin goes outwards,
/// count with their weight over the weight of the next inner tissue (mean of the layer there, label by
/// label). `weights`: with BelowAir::straight; `grown`: moments of grow_skin's labels with these weights.
/// Errors: as label_moments.
Result<SkinVolumes> volumes_with_skin(const LabelMap& labels, const Volume<std::int16_t>& grey,
                                      const GreyWeights& weights, const LabelMoments& grown,
                                      double blur_reach = 2, int threads = 0);

/// Tells whether voxels at the skin are mixtures, as from a scanner, or points, as in a drawn volume. Of the
/// outside voxels with a neighbour in the body along an axis, the share whose weight is 20 to 80 % of water's
/// (1000 kg/m^3). It is nearly zero for points if noise stays below 20 %, and about 30 % for averages with a
/// label map cut at half. Errors: as label_moments.
Result<double> mixed_share(const LabelMap& labels, const Volume<std::int16_t>& grey,
                           const GreyWeights& weights);

/// Sampling implied by `mixed_share`: averages above a tenth.
inline Sampling sampling_by(double mixed) { return mixed > 0.1 ? Sampling::averages : Sampling::points; }

}  // namespace borelli
