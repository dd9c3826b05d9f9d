// What pages of drawings share: one HTML file that needs no network, whose drawings are chosen by buttons,
// show tips under the pointer, and lose curves whose names in the legend are clicked. And their tables as
// CSV.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// Element for a page's head: the browser loads nothing from outside the page.
inline constexpr std::string_view page_policy =
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:\">";

/// A row of buttons: each shows the drawings (<div class='plot' data-KIND='VALUE'>) of its value alone.
struct PageButtons {
  std::string kind;
  std::vector<std::pair<std::string, std::string>> values;  ///< value, and what the button says
};

/// The page: title, a heading, the warnings and sentences below it (all plain text), the buttons, then `body`
/// as HTML.
std::string chart_page(std::string_view title, std::string_view heading,
                       const std::vector<std::string>& warnings, const std::vector<std::string>& sentences,
                       const std::vector<PageButtons>& buttons, std::string_view body);

/// Text as it stands in HTML.
std::string html_text(std::string_view text);

/// Text as a quoted field of CSV (RFC 4180), never a formula (plain_cell.hpp).
std::string csv_text(std::string_view text);

}  // namespace borelli
