// How sure a table's numbers are: a standard deviation for every entry, by cause.
//
//   density_curve   the published curves in place of the one that was used: the root mean square of what each
//   makes of the
//                   entry, about the value in the table. Densities need no curve. Of an MR: what each of its
//                   tissues may weigh (mr_tissues.hpp), above all what is dark, for all parts and for each
//   noise           of the scan, estimated from second differences along rows within the body: what of it
//   does not average
//                   out, and what the bends of the density curve make of it. Of an MR: voxels that it
//                   carries over to another tissue
//   partial_volume  of averages (moments.hpp): a twentieth of what the skin's mixed voxels weigh and hold,
//                   and a scanner's blur of 1 mm, which widens a part. Of an MR: where its tissues meet and
//                   at the skin, borders that lie .15 of a voxel farther in or out
//   voxel_size      the errors of voxelised ellipsoids as measured, and planes that voxels round where they
//   lie along the
//                   grid
//   cut_planes      landmarks drawn from their deviations, and the parts cut anew by them, on a sample of the
//   voxels; of parts that no planes cut (convention `bone`), the borders at the column's discs moved with
//   them joint_centres   the same draws, as they move endpoints and axes
// Causes are independent of each other but for the last two, which go into the total together. The draws have
// a fixed seed: the same scan has the same deviations.
#pragma once

#include <string>
#include <vector>

#include "inertia/density.hpp"
#include "inertia/moments.hpp"
#include "inertia/skin.hpp"
#include "inertia/table.hpp"
#include "pipeline/measure.hpp"
#include "segmentation/landmarks.hpp"
#include "segmentation/noise.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

/// What a table was measured from.
struct DeviationInputs {
  std::vector<InertiaRow> rows;  ///< of all labels, which the table's are made of (segment_rows.hpp)
  const GreyVolume& volume;
  const LabelMap& labels;            ///< as they were given
  const LabelMap& counted;           ///< with the skin's mixed voxels, where those count
  const LabelMoments& mass;          ///< of `counted`
  const SkinVolumes& volume_voxels;  ///< of the rows' volumes; of points, no skin
  const DensityCurve& curve;
  Sampling sampling;
  const Landmarks& landmarks;
  const MeasureOptions& options;
};

/// Gives every row of the table, and the whole, their deviations. Labels that our conventions did not cut
/// (given ones) have no planes that could be drawn anew: their rows' notes say that the cuts count as exact.
void add_deviations(InertiaTable& table, const DeviationInputs& inputs);

}  // namespace borelli
