#include "pipeline/charts/page_frame.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace borelli {

namespace data {
extern const char* const page_style;
extern const char* const uplot_program;
}  // namespace data

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '&'   ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

std::string script_json(const nlohmann::json& value) {
  std::string escaped;
  for (const char c : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace))
    if (c == '<')
      escaped += "\\u003c";
    else
      escaped += c;
  return escaped;
}

std::string page_head(std::string_view title, std::string_view style) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n{}\n<meta name=\"color-scheme\" content=\"light "
      "dark\">\n<meta name=\"generator\" content=\"borelli\">\n<link rel=\"icon\" "
      "href=\"data:,\">\n<title>{} – borelli</title>\n<style>{}</style>\n<style>{}</style>\n</head>\n<body>\n"
      "<main id=\"page\">",
      page_policy, html_text(title), data::page_style, style);
}

std::string page_end(std::string_view program) {
  return fmt::format("<script>{}</script>\n<script>{}</script>\n</body>\n</html>\n", data::uplot_program,
                     program);
}

}  // namespace borelli
