// TRC: Motion Analysis' text format of marker positions, which OpenSim reads.
//
// Line 1: PathFileType, 4 (or 3), (X/Y/Z), name. Lines 2 and 3: keys and their values (DataRate, CameraRate,
// NumFrames, NumMarkers, Units, and in type 4 OrigDataRate, OrigDataStartFrame, OrigNumFrames). Line 4:
// Frame#, Time and the markers' names, each over three columns. Line 5: X1, Y1, Z1, X2, ... Then a row per
// frame. Source: OpenSim's documentation "Marker (.trc) Files" and its readers (opensim-core,
// OpenSim/Common/TRCFileAdapter.cpp and MarkerData.cpp).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/marker_motion.hpp"

namespace borelli {

struct TrcFile {
  MarkerMotion motion;
  double data_rate = 0;               ///< Hz; 0: the file says none
  double camera_rate = 0;             ///< Hz, likewise
  std::string unit = "mm";            ///< of the coordinates in the file
  long first_frame = 1;               ///< number of the first row
  std::vector<std::string> warnings;  ///< a sentence each, without the file's name
};

/// Reads a TRC file, with line ends of any system.
///
/// Cells are between tabs; a row without tabs is split at blanks. Names may be followed by any number of
/// tabs. An empty cell or NaN is a gap, as are cells after a row's end; a marker is visible if it has all
/// three coordinates. Rows of blanks are skipped.
///
/// If the header contradicts the data, the rows override NumFrames, with a warning. The names override
/// NumMarkers, with a warning, if line 5 has three labels for each name; otherwise the file is refused.
///
/// Errors, with their line: not a TRC file; an unknown unit; a marker that is named twice; a cell that is no
/// number; a row with more cells than columns; times that do not rise; no rows; too large.
Result<TrcFile> read_trc(const std::filesystem::path& path);
Result<TrcFile> parse_trc(std::string_view text, const std::string& file);

/// The file's text, in `unit` and with 15 significant digits; `name` is the file's, for its header. Gaps are
/// NaN, which OpenSim reads in every version. A data rate of zero is replaced by that of the mean time step.
/// Errors: a motion whose times, frames and names do not match; names that are empty, doubled or hold tabs or
/// line ends.
Result<std::string> trc_text(const TrcFile& trc, const std::string& name);

}  // namespace borelli
