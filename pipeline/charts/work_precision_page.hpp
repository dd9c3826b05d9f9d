// What a work-precision run has to show: drawings for papers, a page to look at, a table for other programs.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/charts/plot.hpp"
#include "pipeline/charts/work_precision.hpp"

namespace borelli {

/// Which method to take for an error of 10^-digits at most: the trusted run that takes the least time.
struct Recommendation {
  int digits;
  const WorkPrecisionPoint* point;
};

/// One entry per power of ten that any trusted run of ours comes to, from 1 on; errors are of position (over
/// the scene's length) and orientation (rad), whichever is larger.
std::vector<Recommendation> recommendations(const WorkPrecision& chart);

/// The fastest trusted run of ours, and of the other programs, with an error of 10^-digits at most (position
/// and orientation, as above); null: there is none.
struct FrontRow {
  int digits;
  const WorkPrecisionPoint *ours, *other;
};

/// From 1 to 10 digits.
std::vector<FrontRow> front_against_front(const WorkPrecision& chart);

/// The same as a table in Markdown, without the rows that none comes to.
std::string front_table(const WorkPrecision& chart);

/// Each error that the scene has against processor time and against evaluations: file name (without ending)
/// and drawing.
std::vector<std::pair<std::string, Plot>> work_precision_plots(const WorkPrecision& chart);

/// Why there is no drawing, as a sentence; empty where there is one.
std::string why_no_drawing(const WorkPrecision& chart);

/// All of it on one page that needs no network: the drawings with tips and curves to be taken out, the table
/// of recommendations, the runs that failed and why. `warnings`: the model reader's.
std::string work_precision_page(const WorkPrecision& chart, const std::vector<std::string>& warnings = {});

/// A line per run; numbers with 17 significant digits.
std::string work_precision_csv(const WorkPrecision& chart);

/// Every file that write_work_precision may make.
std::vector<std::string> work_precision_files();

/// All of these in a folder: chart.html, chart.csv, and each drawing as SVG and PNG.
Result<void> write_work_precision(const WorkPrecision& chart, const std::filesystem::path& folder,
                                  const std::vector<std::string>& warnings = {});

}  // namespace borelli
