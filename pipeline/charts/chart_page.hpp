// Shared parts of pages of drawings: one HTML file that needs no network. Buttons choose the drawings, tips
// appear under the pointer, and a click on a name in the legend hides its curve. Also tables as CSV.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// HTML element for a page's head: forbids the browser to load anything from outside the page.
inline constexpr std::string_view page_policy =
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:\">";

/// A row of buttons: each shows only the drawings (<div class='plot' data-KIND='VALUE'>) of its value.
struct PageButtons {
  std::string kind;
  std::vector<std::pair<std::string, std::string>> values;  ///< value, and the button's text
};

/// The page: title, heading, warnings and sentences (all plain text), buttons, then `body` as HTML.
std::string chart_page(std::string_view title, std::string_view heading,
                       const std::vector<std::string>& warnings, const std::vector<std::string>& sentences,
                       const std::vector<PageButtons>& buttons, std::string_view body);

/// Escapes text for HTML.
std::string html_text(std::string_view text);

/// Text as a quoted field of CSV (RFC 4180), never a formula (plain_cell.hpp).
std::string csv_text(std::string_view text);

}  // namespace borelli
