// Finds how coarse a scan may be: varies voxels, work grid, number of parts and density curve, each against
// the error of the inertia table and the time.
//
// Errors (entry_errors) are against the table of the scan's own voxels with parts found on the finest grid
// (grids_to_try). They measure what coarsening loses, not the error of the scan itself. The reference's own
// error is unknown. Its difference from the next coarser grid's table is the resolution of these errors;
// nothing coarser is picked for a smaller tolerance. Coarser voxels are means over blocks of the scan's own,
// like a scanner with thicker slices and larger pixels.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/charts/plot.hpp"

namespace borelli {

/// Number of parts after merging, and the SegmentChoice's text.
struct PartsChoice {
  int count;
  const char* segments;
};
inline constexpr PartsChoice parts_choices[] = {
    {16, ""},
    {14,
     "head,trunk,upper_arm_left,upper_arm_right,forearm_left,forearm_right,hand_left,hand_right,thigh_left,"
     "thigh_right,shank_left,shank_right,foot_left,foot_right"},
    {6, "head,trunk,arm_left,arm_right,leg_left,leg_right"}};

/// A measurement of the scan with one property coarser or different.
struct VolumeTrial {
  enum class Of { work_grid, voxels, density_curve };
  Of of = Of::work_grid;
  double size = 0;        ///< mm, of the work grid, or the voxels' longest edge
  std::string name = {};  ///< "4.5 mm", "4 x 4 x 5 mm", or the curve's name
  double seconds = 0;     ///< processor time of all threads, s: parts and table; for a curve the table alone
  std::string reason = {};  ///< why there is no table; empty: there is one
  /// By parts_choices: the errors of its rows.
  std::vector<std::vector<EntryErrors>> errors = {};
  double worst(std::size_t choice) const;  ///< infinite if there is no table
};

struct VolumeEconomy {
  double tolerance = 0;
  std::string curve = {};                  ///< density curve of the scan; empty: its voxels are densities
  std::vector<VolumeTrial> trials = {};    ///< first the scan as it is, on the finest grid
  std::vector<std::string> warnings = {};  ///< about the parts and table of the first trial
  /// The trial on the grid next to the finest; null: there is none.
  const VolumeTrial* next_to_reference() const;
  /// Difference between that trial and the reference; 0: there is none.
  double doubt(std::size_t choice) const;
  /// The coarsest trial of a kind (not curves) for which it and all finer ones are within the tolerance;
  /// null: none. Only the finest if the tolerance is below the doubt.
  const VolumeTrial* pick(VolumeTrial::Of of, std::size_t choice) const;
};

/// Means over blocks of `factors` voxels along each axis; incomplete blocks at the far faces are dropped.
GreyVolume coarsened(const GreyVolume& volume, const std::array<std::int64_t, 3>& factors);

/// Factors of the coarser voxels to try: those nearest to a list of edges in mm.
std::vector<std::array<std::int64_t, 3>> coarser_voxels(const Grid& grid);

/// For a CT or density volume. Errors: as segment() and measure().
Result<VolumeEconomy> volume_economy(
    const GreyVolume& volume, double tolerance, int threads = 0,
    const std::function<void(double)>& progress = [](double) {});

/// File name and drawing: error and time against the size of voxels and of the work grid.
std::vector<std::pair<std::string, Plot>> volume_economy_plots(const VolumeEconomy& economy);
inline std::vector<std::string> volume_economy_plot_names() {
  return {"grid_error", "grid_time", "voxels_error", "voxels_time"};
}
std::string volume_economy_page(const VolumeEconomy& economy, const std::string& title,
                                const std::vector<std::string>& warnings = {});
/// One line per trial and choice of parts.
std::string volume_economy_csv(const VolumeEconomy& economy);
/// Recommendations, one sentence each.
std::vector<std::string> in_words(const VolumeEconomy& economy);

}  // namespace borelli
