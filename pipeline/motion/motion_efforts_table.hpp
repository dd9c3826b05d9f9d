// Inverse dynamics of a whole recording: joint efforts, powers and what remains at the root.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/inverse/motion_efforts.hpp"
#include "dynamics/inverse/recorded_motion.hpp"
#include "pipeline/recordings/external_loads.hpp"
#include "pipeline/recordings/motion_table.hpp"

namespace borelli {

/// The column of a coordinate, by its name or by the path of OpenSim's states (".../name/value"); -1: none.
Eigen::Index coordinate_column(const MotionTable& table, const std::string& name);

/// The positions of a system's free coordinates in a table.
struct TablePositions {
  RecordedPositions positions;
  std::vector<std::string> warnings;
};

/// Columns are found by the coordinate's name, or by the path of OpenSim's states (".../name/value"); a ball
/// has four (name.w, .x, .y, .z). Angles are turned to rad where the table is in degrees. A coordinate
/// without a column follows its coupling if it has one; otherwise it stays at its initial value. Columns that
/// are not coordinates are left out. A warning names both. Errors: no column for any coordinate; a value that
/// is not finite.
Result<TablePositions> positions_in(const System& system, const MotionTable& table);

struct MotionEffortsRequest {
  double cutoff = 0;  ///< Hz, of the low-pass filter over the positions; 0: none
  std::pair<double, double> time_range{-std::numeric_limits<double>::infinity(),
                                       std::numeric_limits<double>::infinity()};
  std::function<void(double)> progress;  ///< called with the share done, 0 to 1; may be empty
};

/// The effort that remains at the root's coordinates. It would be zero for exact masses, motion and measured
/// forces, so it shows their errors.
struct RootResidual {
  std::string coordinate;
  bool angle = false;  ///< N m, otherwise N
  double rms = 0, peak = 0;
};

struct RecordedEfforts {
  std::vector<double> times;
  Rows q, v, a;  ///< the smooth motion: #times by nq, nv, nv
  Rows efforts;  ///< #times by nv, N or N m
  Rows powers;   ///< #times by nv, W: effort times velocity
  std::vector<RootResidual> residuals;
  double peak_force = 0;  ///< N, the largest measured force; 0: none
  std::vector<std::string> warnings;
};

/// At the table's times within the range. A load's force, point and moment are interpolated linearly between
/// its samples and zero outside of them; where the point is not known, the force is left out. Errors: a load
/// on a solid that the model does not have; as RecordedMotion.
Result<RecordedEfforts> efforts_of(const System& system, const RecordedPositions& positions,
                                   const std::vector<ExternalLoad>& loads,
                                   const MotionEffortsRequest& request);

/// Columns as OpenSim names them: the coordinate's name and _moment or _force.
MotionTable effort_table_of(const System& system, const RecordedEfforts& efforts);
/// Columns: the coordinate's name and _power, W.
MotionTable power_table_of(const System& system, const RecordedEfforts& efforts);

}  // namespace borelli
