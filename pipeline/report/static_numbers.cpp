#include "pipeline/report/static_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "pipeline/charts/chart_page.hpp"

namespace borelli {
namespace {

using nlohmann::json;

/// The value at a path of keys and indices; null: there is none.
json entry_at(const json& from, const char* pointer) {
  const json::json_pointer path(pointer);
  return from.is_structured() && from.contains(path) ? from.at(path) : json();
}

/// A dash for what is missing.
std::string number_cell(const json& value, int decimals, double factor = 1) {
  return value.is_number() ? fmt::format("{:.{}f}", factor * value.get<double>(), decimals) : "–";
}

/// "upper_arm_left": "Left upper arm", as partTitle() of the page's program.
std::string part_title(std::string name) {
  for (const std::string side : {"left", "right"})
    if (name.ends_with("_" + side)) name = side + "_" + name.substr(0, name.size() - side.size() - 1);
  std::ranges::replace(name, '_', ' ');
  if (!name.empty() && name[0] >= 'a' && name[0] <= 'z') name[0] = char(name[0] - 'a' + 'A');
  return name;
}

std::string inertia_table(const json& table) {
  constexpr auto number = PageColumn::Kind::number;
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const json& part, const std::string& title) {
    rows.push_back({html_text(title), number_cell(entry_at(part, "/volume_m3"), 3, 1e3),
                    number_cell(entry_at(part, "/mass_kg"), 3),
                    number_cell(entry_at(part, "/derived/mass_pct"), 2)});
    for (const char* c : {"/centre_m/0", "/centre_m/1", "/centre_m/2"})
      rows.back().push_back(number_cell(entry_at(part, c), 1, 1e3));
    for (const char* moment : {"/derived/principal_moments_kgm2/0", "/derived/principal_moments_kgm2/1",
                               "/derived/principal_moments_kgm2/2"})
      rows.back().push_back(number_cell(entry_at(part, moment), 2, 1e4));
  };
  for (const json& part : entry_at(table, "/parts"))
    if (part.is_object()) add(part, part_title(part.value("part", "")));
  if (const json body = entry_at(table, "/body"); body.is_object()) add(body, "All parts");
  return "<section><h2>Parts and their inertia</h2>\n" +
         page_table(
             "Gravity centre in the patient frame (x to the left, y to the back, z up); principal moments "
             "of inertia about it",
             {{"part"},
              {"volume (l)", number},
              {"mass (kg)", number},
              {"share (%)", number},
              {"x (mm)", number},
              {"y (mm)", number},
              {"z (mm)", number},
              {"smallest (kg cm²)", number},
              {"middle", number},
              {"largest", number}},
             rows) +
         "</section>\n";
}

}  // namespace

std::string static_numbers(const json& report) {
  std::string out = "<header><p class=\"wordmark\">borelli</p><h1>" + html_text(report.value("subject", "")) +
                    "</h1>\n<noscript><p class=\"notice\">Without JavaScript this page shows its numbers "
                    "only.</p></noscript>\n";
  std::vector<json> lists{entry_at(report, "/run/warnings"), entry_at(report, "/segmentation/warnings")};
  for (const json& stage : entry_at(report, "/run/stages")) lists.push_back(entry_at(stage, "/warnings"));
  std::vector<std::string> warnings;
  for (const json& list : lists)
    for (const json& text : list)
      if (text.is_string() && std::ranges::find(warnings, text.get<std::string>()) == warnings.end())
        warnings.push_back(text);
  for (const std::string& warning : warnings)
    out += "<p class=\"notice\">Warning: " + html_text(warning) + "</p>\n";
  if (const json trusted = entry_at(report, "/motion/certificate/trusted"); trusted.is_boolean()) {
    const json reason = entry_at(report, "/motion/certificate/reason");
    out += trusted.get<bool>()
               ? std::string("<p>The motion is trusted by its certificate.</p>\n")
               : "<p>The motion is not trusted: " +
                     html_text(reason.is_string() ? reason.get<std::string>() : "no reason given") +
                     ".</p>\n";
  }
  out += "</header>\n";
  if (const json table = entry_at(report, "/table"); table.is_object()) out += inertia_table(table);
  return out;
}

}  // namespace borelli
