// What every page shares: head, style, the program that draws charts. A page is one HTML file that opens from
// file:// and loads nothing.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace borelli {

/// HTML element for a page's head: forbids the browser to load anything from outside the page.
inline constexpr std::string_view page_policy =
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:\">";

/// The page from its doctype to the opening <main id="page">, with the shared style, then `style`.
/// `title`: plain text.
std::string page_head(std::string_view title, std::string_view style);

/// The page after its <main> and data: uPlot as the global `uPlot`, then `program`, both as scripts.
std::string page_end(std::string_view program);

/// JSON that cannot end its enclosing script element; bytes that are not UTF-8 become U+FFFD.
std::string script_json(const nlohmann::json& value);

/// Escapes text for HTML.
std::string html_text(std::string_view text);

}  // namespace borelli
