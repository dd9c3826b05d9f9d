// The standard deviation of every entry of a table, by cause.
//
//   density_curve   root mean square of the entry's changes when the published curves replace the one used.
//                   Densities need no curve. MR: what each of its tissues may weigh (mr_tissues.hpp), above all
//                   dark tissue, for all parts together and for each part
//   noise           of the scan, estimated from second differences along rows within the body: what does not
//                   average out, and what the bends of the density curve make of it. MR: voxels that noise
//                   carries over to another tissue
//   partial_volume  of averages (moments.hpp): a twentieth of what the skin's mixed voxels weigh and hold, and
//                   a scanner's blur of 1 mm, which widens a part. MR: borders of tissues and of the skin that
//                   lie .15 of a voxel farther in or out
//   voxel_size      measured errors of voxelised ellipsoids, and planes that voxels round where they lie along
//                   the grid
//   cut_planes      landmarks drawn from their deviations, and the parts cut anew by them, on a sample of the
//                   voxels. Parts that no planes cut (convention `bone`): the borders at the column's discs
//                   move with them
//   joint_centres   the same draws, as they move endpoints and axes
// Causes are taken as independent, but for the last two, which go into the total together. The draws have a
// fixed seed: the same scan has the same deviations.
#pragma once

#include <string>
#include <vector>

#include "inertia/density.hpp"
#include "inertia/moments.hpp"
#include "inertia/skin.hpp"
#include "inertia/table.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/grid/noise.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

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
