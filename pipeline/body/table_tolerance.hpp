// The coarsest grid for finding parts that still gives every entry of the table within a tolerance.
//
// Distance maps, smoothing and geodesics run on the work grid, and their cost goes with the third power of
// its fineness; labels and moments are taken on the scan's own voxels by any grid. How far a grid is off is
// not known beforehand (it depends on the body, on slices, on noise) but seen: the parts are found on ever
// finer grids, and the first that agrees with the coarser one before it within half the tolerance is taken,
// unless landmarks that are known to jump between grids could be off by more.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/segment.hpp"

namespace borelli {

/// How far a segment's entries are off, relative: the mass, the gravity centre (in parts of the segment's
/// length, where it has none of the cube root of its volume), the principal moment that is off most.
struct EntryErrors {
  std::string part;
  double mass = 0, centre = 0, moments = 0;
  double largest() const { return std::max({mass, centre, moments}); }
};

/// By segment of `table`, against `reference`. One that either has not, or not as the other has it (whole,
/// cut), is off by 1.
std::vector<EntryErrors> entry_errors(const InertiaTable& table, const InertiaTable& reference);

/// What was picked for a tolerance, and why.
struct GridPick {
  double tolerance = 0;             ///< share
  double step = 0;                  ///< mm, of the grid picked
  double against = 0;               ///< mm, of the coarser grid that it was compared with; 0: with none
  bool met = false;                 ///< the tolerance; else `step` is the finest grid there is
  std::vector<EntryErrors> errors;  ///< estimated, of the table by `step`: twice what the two grids differ
                                    ///< by, and no less than errors_of_jumps
};

/// Steps of the grids that are tried for a volume, mm, coarse to fine: down to its finest voxel edge, not
/// below 2 mm, where a body's grid fills the memory.
std::vector<double> grids_to_try(const GreyVolume& volume);

/// The table that a grid gives: none where it finds no part.
struct GridTable {
  double step = 0;  ///< mm
  std::optional<InertiaTable> table = {};
};

/// What landmarks that jump between grids make of each segment's entries at the least, however well two grids
/// agree. `coarsest_edge`: of the scan's voxels, mm.
std::vector<EntryErrors> errors_of_jumps(const InertiaTable& table, double coarsest_edge);

/// Whether a grid gives a tolerance, by what its table differs from that of the coarser grid before it and by
/// errors_of_jumps.
GridPick judged(const GridTable& coarser, const GridTable& here, double tolerance, double coarsest_edge);

/// Parts by the coarsest of those grids that gives the rows asked for by `measuring` within `tolerance` (a
/// share), else by the finest. `options.step` is not used. Errors: as segment.
Result<Segmentation> segment_within(const GreyVolume& volume, double tolerance, const SegmentOptions& options,
                                    const MeasureOptions& measuring, GridPick& pick);

/// "grid of 4.5 mm for 1 %: against 6 mm ..." in one line.
std::string in_words(const GridPick& pick);
nlohmann::json to_json(const GridPick& pick);

/// Where the voxels themselves (noise, partial volume, voxel size) leave an entry of the table with a
/// standard deviation above the tolerance: a sentence that names the worst. Empty where none is.
std::string beyond_the_voxels(const InertiaTable& table, double tolerance);

/// "1%", "1 %" or "0.01" as a share. Error: another text, or not within low to high.
Result<double> parse_tolerance(std::string text, double low = 0.001, double high = 0.5);

}  // namespace borelli
