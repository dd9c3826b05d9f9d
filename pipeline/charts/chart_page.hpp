// Pages of charts: buttons choose the chart, tables give its numbers. Also text as a field of CSV.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/charts/page_frame.hpp"
#include "pipeline/charts/page_plots.hpp"

namespace borelli {

/// One choice of a page: a button (or an entry of a list) per value shows only the plots of that value.
struct PageButtons {
  std::string kind;                                         ///< lowercase letters
  std::string title;                                        ///< label of the choice
  std::vector<std::pair<std::string, std::string>> values;  ///< value, and the button's text
};

struct ChartPage {
  std::string title, heading;  ///< plain text, as the warnings and sentences
  std::vector<std::string> warnings = {}, sentences = {};
  std::vector<PageButtons> buttons = {};
  std::vector<PagePlot> plots = {};
  std::string body = {};  ///< HTML below the plots: tables of numbers
};

/// The page, which needs no network.
std::string chart_page(const ChartPage& page);

struct PageColumn {
  std::string title;                                          ///< HTML
  enum class Kind { name, number, words } kind = Kind::name;  ///< words: sentences, which are wrapped
};

/// A table that scrolls within itself. Its cells are HTML; the first of a row heads it. `caption`: HTML, may
/// be empty.
std::string page_table(std::string_view caption, const std::vector<PageColumn>& columns,
                       const std::vector<std::vector<std::string>>& rows);

/// Text as a quoted field of CSV (RFC 4180), never a formula (plain_cell.hpp).
std::string csv_text(std::string_view text);

}  // namespace borelli
