// Output of a work-precision run: drawings for papers, a page, a table for other programs.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/charts/plot.hpp"
#include "pipeline/charts/work_precision.hpp"

namespace borelli {

/// The method to take for an error of at most 10^-digits: the fastest trusted run.
struct Recommendation {
  int digits;
  const WorkPrecisionPoint* point;
};

/// One entry per power of ten that a trusted run of ours reaches, from 1 on. The error is the larger of
/// position (over the scene's length) and orientation (rad).
std::vector<Recommendation> recommendations(const WorkPrecision& chart);

/// The fastest trusted run of ours and of other programs, with an error of at most 10^-digits (as above);
/// null: none.
struct FrontRow {
  int digits;
  const WorkPrecisionPoint *ours, *other;
};

/// From 1 to 10 digits.
std::vector<FrontRow> front_against_front(const WorkPrecision& chart);

/// front_against_front as a Markdown table, without the rows that no run reaches.
std::string front_table(const WorkPrecision& chart);

/// File name (without extension) and drawing: each error of the scene against processor time and against
/// evaluations.
std::vector<std::pair<std::string, Plot>> work_precision_plots(const WorkPrecision& chart);

/// Why there is no drawing, as a sentence; empty where there is one.
std::string why_no_drawing(const WorkPrecision& chart);

/// One page that needs no network: drawings with tips and curves that can be hidden, the table of
/// recommendations, the failed runs with reasons. `warnings`: from the reader of the model.
std::string work_precision_page(const WorkPrecision& chart, const std::vector<std::string>& warnings = {});

/// One line per run; numbers have 17 significant digits.
std::string work_precision_csv(const WorkPrecision& chart);

/// All files that write_work_precision may write.
std::vector<std::string> work_precision_files();

/// Writes chart.html, chart.csv, and each drawing as SVG and PNG into a folder.
Result<void> write_work_precision(const WorkPrecision& chart, const std::filesystem::path& folder,
                                  const std::vector<std::string>& warnings = {});

}  // namespace borelli
