#include "pipeline/charts/chart_page.hpp"

#include <fmt/format.h>

#include "error/plain_cell.hpp"

namespace borelli {

namespace data {
extern const char* const chart_program;
extern const char* const chart_style;
}  // namespace data

namespace {

// more buttons than these are a list to choose from
constexpr std::size_t most_buttons = 8;

/// The buttons of one choice. They are hidden until the page's program runs.
std::string buttons_html(const PageButtons& row) {
  if (row.values.size() < 2) return "";
  std::string out =
      fmt::format("<div class=\"choices\" role=\"group\" aria-label=\"{}\" data-kind=\"{}\" hidden>",
                  html_text(row.title), row.kind);
  if (row.values.size() > most_buttons) {
    out += fmt::format("<label>{} <select>", html_text(row.title));
    for (const auto& [value, says] : row.values)
      out += fmt::format("<option value=\"{}\">{}</option>", html_text(value), html_text(says));
    return out + "</select></label></div>\n";
  }
  for (const auto& [value, says] : row.values)
    out += fmt::format("<button value=\"{}\">{}</button>", html_text(value), html_text(says));
  return out + "</div>\n";
}

std::string warnings_html(const std::vector<std::string>& warnings) {
  std::string out;
  for (const std::string& warning : warnings)
    out += "<p class=\"notice\">Warning: " + html_text(warning) + "</p>\n";
  return out;
}

}  // namespace

std::string csv_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : plain_cell(text)) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + '"';
}

std::string page_table(std::string_view caption, const std::vector<PageColumn>& columns,
                       const std::vector<std::vector<std::string>>& rows) {
  std::string out = "<div class=\"scroll\" tabindex=\"0\"><table class=\"numbers\">";
  if (!caption.empty()) out += fmt::format("<caption>{}</caption>", caption);
  out += "<thead><tr>";
  const auto class_of = [&](std::size_t column) {
    using enum PageColumn::Kind;
    const PageColumn::Kind it = columns[column].kind;
    return it == number ? " class=\"number\"" : it == words ? " class=\"words\"" : "";
  };
  for (std::size_t i = 0; i < columns.size(); ++i)
    out += fmt::format("<th scope=\"col\"{}>{}</th>", class_of(i), columns[i].title);
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    out += fmt::format("<tr><th scope=\"row\">{}</th>", row.front());
    for (std::size_t i = 1; i < row.size(); ++i) out += fmt::format("<td{}>{}</td>", class_of(i), row[i]);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string chart_page(const ChartPage& page) {
  std::string out = page_head(page.title, data::chart_style);
  out += "<header><p class=\"wordmark\">borelli</p><h1>" + html_text(page.heading) + "</h1>\n" +
         warnings_html(page.warnings);
  for (const std::string& sentence : page.sentences) out += "<p>" + html_text(sentence) + "</p>\n";
  out += "</header>\n";
  for (const PageButtons& row : page.buttons) out += buttons_html(row);
  return out + page_plots(page.plots) + page.body + "</main>\n" + page_end(data::chart_program);
}

}  // namespace borelli
