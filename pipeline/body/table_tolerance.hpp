// The coarsest grid for finding parts that still gives every entry of the table within a tolerance.
//
// Distance maps, smoothing and geodesics run on the work grid, and their cost grows with the inverse cube of
// its step; labels and moments always use the scan's own voxels. A grid's error depends on the body, slices
// and noise and is not known in advance. So the parts are found on ever finer grids. The first grid that
// agrees with the next coarser one within half the tolerance is taken, unless landmarks known to jump between
// grids could cause a larger error.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// Relative errors of a segment's entries: mass; gravity centre (over the segment's length, or the cube root
/// of its volume if it has none); the principal moment with the largest error.
struct EntryErrors {
  std::string part;
  double mass = 0, centre = 0, moments = 0;
  double largest() const { return std::max({mass, centre, moments}); }
};

/// Errors by segment of `table` against `reference`. A segment that one of them lacks, or that has another
/// completeness (whole, cut), has errors of 1.
std::vector<EntryErrors> entry_errors(const InertiaTable& table, const InertiaTable& reference);

/// The grid picked for a tolerance, and why.
struct GridPick {
  double tolerance = 0;             ///< share
  double step = 0;                  ///< mm, of the grid picked
  double against = 0;               ///< mm, step of the coarser grid it was compared with; 0: none
  bool met = false;                 ///< whether the tolerance is met; if not, `step` is the finest grid's
  std::vector<EntryErrors> errors;  ///< estimated, of the table by `step`: twice what the two grids differ
                                    ///< by, and no less than errors_of_jumps
};

/// Steps of the grids to try for a volume, mm, coarse to fine: down to the finest voxel edge, but at least 2
/// mm, since finer grids of a body do not fit into memory.
std::vector<double> grids_to_try(const GreyVolume& volume);

/// The table from one grid; none if no part is found.
struct GridTable {
  double step = 0;  ///< mm
  std::optional<InertiaTable> table = {};
};

/// Least errors of each segment's entries caused by landmarks that jump between grids, however well two grids
/// agree. `coarsest_edge`: of the scan's voxels, mm.
std::vector<EntryErrors> errors_of_jumps(const InertiaTable& table, double coarsest_edge);

/// Whether a grid meets a tolerance, judged by its difference from the next coarser grid's table and by
/// errors_of_jumps.
GridPick judged(const GridTable& coarser, const GridTable& here, double tolerance, double coarsest_edge);

/// Finds the parts on the coarsest of those grids that gives the rows requested by `measuring` within
/// `tolerance` (a share); if none does, on the finest. Ignores `options.step`. Errors: as segment.
Result<Segmentation> segment_within(const GreyVolume& volume, double tolerance, const SegmentOptions& options,
                                    const MeasureOptions& measuring, GridPick& pick);

/// One line: "grid of 4.5 mm for 1 %: against 6 mm ...".
std::string in_words(const GridPick& pick);
nlohmann::json to_json(const GridPick& pick);

/// If the voxels themselves (noise, partial volume, voxel size) give an entry of the table a standard
/// deviation above the tolerance, a sentence that names the worst; otherwise "".
std::string beyond_the_voxels(const InertiaTable& table, double tolerance);

/// "1%", "1 %" or "0.01" as a share. Errors: any other text, or a share outside low to high.
Result<double> parse_tolerance(std::string text, double low = 0.001, double high = 0.5);

}  // namespace borelli
