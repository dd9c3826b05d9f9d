// OpenSim's .mot and .sto files, and SIMM's older .mot: a header, a line of names, and a row per time.
//
// The header's first line is the title. Further lines are `key=value` (version, nRows, nColumns, inDegrees)
// or, in SIMM's files, `key value` (name, datarows, datacolumns, range, otherdata); other lines are remarks.
// `endheader` ends it. Source: OpenSim's documentation "Storage (.sto) Files" and "Motion (.mot) Files", and
// its readers (opensim-core, OpenSim/Common/Storage.cpp and DelimFileAdapter.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/motion_table.hpp"

namespace borelli {

struct MotionTableFile {
  MotionTable table;
  std::vector<std::string> warnings;  ///< a sentence each, without the file's name
};

/// Reads a table of plain numbers. Cells are between tabs; where their count does not match, between blanks.
///
/// Time is the column named "time". A file of SIMM that has none gives `range START END`: then the rows are
/// equally spaced over it. Cells that are empty or NaN are NaN.
///
/// `in_degrees`: what `inDegrees` says; without it and without a version, "Angles are in degrees." or
/// "Angles are in radians."; without that, a .mot file is in degrees (SIMM's convention), any other is not.
///
/// What is there wins over nRows and nColumns, with a warning. Of rows at one time the first is kept, with a
/// warning.
///
/// Errors, with their line: no `endheader`; a column named twice; no time; a row with fewer or
/// more cells than names; a cell that is no number; times that fall; no rows; tables of vectors
/// or quaternions (DataType); too large.
Result<MotionTableFile> read_motion_table(const std::filesystem::path& path);
Result<MotionTableFile> parse_motion_table(std::string_view text, const std::string& file);

/// Writes to exactly this path, in the layout of version 1, which every OpenSim reads; each number reads back
/// as the same double. Errors: sizes that do not match; times that do not rise; names that are empty or
/// doubled, or hold blanks, where OpenSim would cut them; infinite values; not writable.
Result<void> write_motion_table(const MotionTable& table, const std::filesystem::path& path);
Result<std::string> motion_table_text(const MotionTable& table, const std::string& name);

}  // namespace borelli
