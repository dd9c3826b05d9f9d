// The standard deviation of every entry of a table, by cause.
//
//   density_curve   root mean square of the entry's changes when each published curve replaces the one used.
//                   Densities need no curve. MR: the uncertain density of each tissue (mr_tissues.hpp),
//                   above all of dark tissue, for all parts together and for each part
//   noise           noise of the scan, estimated from second differences along rows within the body: its
//                   random remainder in each sum, and its bias where the density curve bends. MR: voxels
//                   that noise moves into another tissue
//   partial_volume  averages (moments.hpp): a twentieth of the mass and volume of the skin's mixed voxels,
//                   and a scanner blur of 1 mm, which widens a part. MR: borders of tissues and skin shifted
//                   by 0.15 of a voxel
//   voxel_size      measured errors of voxelised ellipsoids, and rounding of cut planes that lie along the
//                   grid
//   cut_planes      landmarks drawn at random from their deviations; the parts are cut again by them, on a
//                   sample of the voxels. Parts without cut planes (convention `bone`): the borders at the
//                   spine's discs move with the discs
//   joint_centres   the same draws move endpoints and axes
// The seed is fixed, so the same scan has the same deviations.
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
  std::vector<InertiaRow> rows;  ///< of all labels; the table's rows are made of them (segment_rows.hpp)
  const GreyVolume& volume;
  const LabelMap& labels;            ///< as given
  const LabelMap& counted;           ///< including the skin's mixed voxels, if those count
  const LabelMoments& mass;          ///< moments of `counted`
  const SkinVolumes& volume_voxels;  ///< volumes of the rows; without skin if voxels are points
  const DensityCurve& curve;
  Sampling sampling;
  const Landmarks& landmarks;
  const MeasureOptions& options;
};

/// Adds the deviations to every row of the table and to the whole. Labels that our conventions did not cut
/// (given ones) have no planes to draw; their rows' notes say that the cuts count as exact.
void add_deviations(InertiaTable& table, const DeviationInputs& inputs);

}  // namespace borelli
