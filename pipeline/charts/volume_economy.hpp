// What a scan needs: voxels, the grid that parts are found on, the number of parts, the density curve, each
// against the error of the inertia table and the time.
//
// Errors are against the table of the scan's own voxels with parts found on the finest grid
// (grids_to_try), by entry_errors; they say what is lost from there, not what the scan itself is off by. How
// far that table is off is not known: by how much it and the next coarser grid's differ is the least that the
// errors can be trusted to, and nothing coarser is picked for a tolerance below.
// Coarser voxels are means over blocks of the scan's own, as a scanner of thicker slices and larger pixels
// gives.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/body/table_tolerance.hpp"
#include "pipeline/charts/plot.hpp"

namespace borelli {

/// Parts that count as one: how many are left, and the SegmentChoice's text.
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

/// The scan measured with one thing coarser, or other, than as it is.
struct VolumeTrial {
  enum class Of { work_grid, voxels, density_curve };
  Of of = Of::work_grid;
  double size = 0;          ///< mm, of the work grid or of the voxels' longest edge
  std::string name = {};    ///< "4.5 mm", "4 x 4 x 5 mm", the curve's
  double seconds = 0;       ///< of processor time, all threads: parts and table; the table alone for a curve
  std::string reason = {};  ///< why there is no table; empty: there is one
  /// By parts_choices: the errors of their rows.
  std::vector<std::vector<EntryErrors>> errors = {};
  double worst(std::size_t choice) const;  ///< infinite where there is no table
};

struct VolumeEconomy {
  double tolerance = 0;
  std::string curve = {};  ///< by which the scan's densities are told; empty: its voxels are densities
  std::vector<VolumeTrial> trials = {};    ///< the first: the scan as it is, on the finest grid
  std::vector<std::string> warnings = {};  ///< about the parts and table of the first trial
  /// Of the grid next to the finest; null: there is none.
  const VolumeTrial* next_to_reference() const;
  /// By how much the reference and that differ; 0: there is none.
  double doubt(std::size_t choice) const;
  /// The coarsest of a kind (not curves) whose table of all such parts is within the tolerance, as are those
  /// of all finer ones; null: none. Nothing but the finest where the tolerance is below the doubt.
  const VolumeTrial* pick(VolumeTrial::Of of, std::size_t choice) const;
};

/// Means over blocks of voxels, so many along each axis; what is left over at the far faces falls away.
GreyVolume coarsened(const GreyVolume& volume, const std::array<std::int64_t, 3>& factors);

/// Edges (mm) that coarser voxels are tried with, with the factors that come nearest to them.
std::vector<std::array<std::int64_t, 3>> coarser_voxels(const Grid& grid);

/// Of a CT or density volume. Fails as segment() and measure() of it do.
Result<VolumeEconomy> volume_economy(
    const GreyVolume& volume, double tolerance, int threads = 0,
    const std::function<void(double)>& progress = [](double) {});

/// Error and time against the size of voxels and of the work grid: file name and drawing.
std::vector<std::pair<std::string, Plot>> volume_economy_plots(const VolumeEconomy& economy);
inline std::vector<std::string> volume_economy_plot_names() {
  return {"grid_error", "grid_time", "voxels_error", "voxels_time"};
}
std::string volume_economy_page(const VolumeEconomy& economy, const std::string& title,
                                const std::vector<std::string>& warnings = {});
/// A line per trial and choice of parts.
std::string volume_economy_csv(const VolumeEconomy& economy);
/// What to take, a sentence each.
std::vector<std::string> in_words(const VolumeEconomy& economy);

}  // namespace borelli
