#include "pipeline/report/effort_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "pipeline/charts/chart_page.hpp"
#include "pipeline/export/glb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

constexpr const char* efforts_file = "motion/efforts.json";
constexpr double most_samples = 1500;

/// Hicks JL et al. (2015) J Biomech Eng 137:020905: a model is good enough where the residual forces stay
/// below this share of the largest external force, percent.
constexpr double residual_advice = 5;

double number_or_nan(const json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

double number_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? number_or_nan(nullptr) : number_or_nan(*found);
}

const json& list_of(const json& object, const char* key) {
  static const json none = json::array();
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : none;
}

/// The fault of `object[key]` as a list of `count` values; none if it is one.
std::optional<std::string> list_fault(const json& object, const char* key, std::size_t count) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_array())
    return fmt::format("'{}' is missing", key);
  if (object[key].size() != count)
    return fmt::format("'{}' has {} values; expected one for each of the {} times", key, object[key].size(),
                       count);
  return std::nullopt;
}

Result<void> check_efforts(const json& efforts) {
  const json& times = list_of(efforts, "times");
  if (times.empty()) return failure(efforts_file, "'times' is missing or empty");
  for (std::size_t i = 0; i < times.size(); ++i)
    if (!times[i].is_number() || (i > 0 && !(times[i].get<double>() > times[i - 1].get<double>())))
      return failure(efforts_file, fmt::format("times[{}] is not a number above the one before", i));
  const auto check = [&](const json& one, const char* kind, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
      if (const auto fault = list_fault(one, key, times.size()))
        return Result<void>(failure(
            efforts_file,
            fmt::format("{} '{}': {}", kind, one.is_object() ? text_of(one, "name") : one.dump(), *fault)));
    return Result<void>();
  };
  for (const json& c : list_of(efforts, "coordinates")) {
    if (auto done = check(c, "coordinate", {"angle_deg", "moment", "power"}); !done) return done;
    if (c.contains("deviation"))
      if (auto done = check(c, "coordinate", {"deviation"}); !done) return done;
  }
  for (const json& force : list_of(efforts, "forces"))
    if (auto done = check(force, "force", {"force", "point"}); !done) return done;
  return {};
}

/// Five digits: finer than a curve's line, and a third of the bytes.
json shortened(const json& value) {
  if (value.is_array()) {
    json list = json::array();
    for (const json& one : value) list.push_back(shortened(one));
    return list;
  }
  const double number = number_or_nan(value);
  if (!std::isfinite(number)) return nullptr;
  return std::strtod(fmt::format("{:.5g}", number).c_str(), nullptr);
}

json thinned(const json& list, const std::vector<std::size_t>& kept) {
  json out = json::array();
  for (const std::size_t i : kept) out.push_back(shortened(list[i]));
  return out;
}

/// Index of the value that is largest in size.
std::size_t largest_of(const json& list) {
  std::size_t at = 0;
  double size = -1;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (const double now = std::abs(number_or_nan(list[i])); now > size) {
      at = i;
      size = now;
    }
  return at;
}

json peak_of(const json& coordinate, const json& times) {
  const std::size_t at = largest_of(coordinate["moment"]), power_at = largest_of(coordinate["power"]);
  json peak{{"moment", coordinate["moment"][at]},
            {"time", times[at]},
            {"power", coordinate["power"][power_at]},
            {"power_time", times[power_at]}};
  if (coordinate.contains("deviation")) peak["deviation"] = coordinate["deviation"][at];
  return peak;
}

/// Adds "group", "side" and "motion", which are in the names of joint and label.
void add_names(json& coordinate) {
  std::string group = text_of(coordinate, "joint"), side;
  for (const std::string one : {"left", "right"})
    if (group.ends_with("_" + one)) {
      group.resize(group.size() - one.size() - 1);
      side = one;
    }
  std::ranges::replace(group, '_', ' ');
  const std::string label = text_of(coordinate, "label");
  const auto comma = label.rfind(", ");
  coordinate["group"] = group;
  coordinate["side"] = side;
  coordinate["motion"] = comma == std::string::npos ? label : label.substr(comma + 2);
}

/// Ankle, knee, hip, then other joints as they come; within one its motions as they come, left before right.
void sort_coordinates(json& coordinates) {
  std::vector<std::string> groups{"ankle", "knee", "hip"}, motions;
  const auto rank = [](std::vector<std::string>& known, const std::string& name) {
    const auto at = std::ranges::find(known, name) - known.begin();
    if (at == std::ssize(known)) known.push_back(name);
    return at;
  };
  std::vector<std::pair<std::array<std::ptrdiff_t, 3>, std::size_t>> order;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const json& c = coordinates[i];
    const auto group = rank(groups, c["group"]);
    order.push_back(
        {{group, rank(motions, fmt::format("{} {}", group, text_of(c, "motion"))), c["side"] == "right"}, i});
  }
  std::ranges::stable_sort(order, {}, [](const auto& one) { return one.first; });
  json sorted = json::array();
  for (const auto& one : order) sorted.push_back(std::move(coordinates[one.second]));
  coordinates = std::move(sorted);
}

json page_efforts(const json& efforts) {
  const auto times = efforts["times"].get<std::vector<double>>();
  const double span = times.back() - times.front();
  const auto kept = kept_samples(times, span > 0 ? most_samples / span : 1);
  json page{{"source", text_of(efforts, "source")},
            {"times", json::array()},
            {"coordinates", json::array()},
            {"residuals", list_of(efforts, "residuals")},
            {"forces", json::array()}};
  for (const std::size_t i : kept) page["times"].push_back(times[i]);
  if (number_of(efforts, "mass_kg") > 0) page["mass_kg"] = efforts["mass_kg"];
  for (const json& c : list_of(efforts, "coordinates")) {
    json one{{"name", text_of(c, "name")}, {"label", text_of(c, "label")}, {"joint", text_of(c, "joint")}};
    add_names(one);
    one["peak"] = peak_of(c, efforts["times"]);
    for (const char* key : {"angle_deg", "moment", "deviation", "power"})
      if (c.contains(key)) one[key] = thinned(c[key], kept);
    if (c.contains("shares")) one["shares"] = c["shares"];
    page["coordinates"].push_back(std::move(one));
  }
  sort_coordinates(page["coordinates"]);
  for (const json& f : list_of(efforts, "forces"))
    page["forces"].push_back({{"name", text_of(f, "name")},
                              {"solid", text_of(f, "solid")},
                              {"force", thinned(f["force"], kept)},
                              {"point", thinned(f["point"], kept)}});
  return page;
}

/// With a true minus sign; a dash for what is not a number.
std::string fixed_text(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  if (text[0] == '-') text.replace(0, 1, "−");
  return text;
}

/// Decimals, at most 3, that show `digits` significant digits of the value.
int decimals_of(double value, int digits) {
  if (!std::isfinite(value) || value == 0) return 0;
  return std::clamp(digits - 1 - int(std::floor(std::log10(std::abs(value)))), 0, 3);
}

std::string significant_text(double value, int digits) {
  return fixed_text(value, decimals_of(value, digits));
}

/// "−48.3 ± 2.1": two digits of the deviation decide how many the value has.
std::string with_deviation(double value, double deviation) {
  if (!(deviation > 0)) return significant_text(value, 3);
  const int decimals = decimals_of(deviation, 2);
  return fixed_text(value, decimals) + " ± " + fixed_text(deviation, decimals);
}

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = char(text[0] - 'a' + 'A');
  return text;
}

/// "joint centres, 60 %": the cause of most of the moment's variance; a dash if none is known.
std::string largest_cause(const json& coordinate) {
  std::string cause;
  double most = 0;
  if (coordinate.contains("shares") && coordinate["shares"].is_object())
    for (const auto& [name, share] : coordinate["shares"].items())
      if (number_or_nan(share) > most) {
        cause = name;
        most = share.get<double>();
      }
  return cause.empty() ? "–" : fmt::format("{}, {:.0f} %", html_text(cause), 100 * most);
}

std::string table_head(const std::vector<std::string>& titles) {
  std::string head = "<thead><tr>";
  for (std::size_t i = 0; i < titles.size(); ++i)
    head += fmt::format("<th scope=\"col\"{}>{}</th>", i > 0 ? " class=\"number\"" : "", titles[i]);
  return head + "</tr></thead>\n<tbody>\n";
}

std::string table_row(const std::string& name, const std::vector<std::string>& cells) {
  std::string row = "<tr><th scope=\"row\">" + html_text(name) + "</th>";
  for (const std::string& cell : cells) row += "<td class=\"number\">" + cell + "</td>";
  return row + "</tr>\n";
}

std::string peak_table(const json& page) {
  const auto& all = page["coordinates"];
  if (all.empty()) return "";
  const bool deviations = std::ranges::any_of(all, [](const json& c) { return c.contains("deviation"); });
  const bool shares = std::ranges::any_of(all, [](const json& c) { return c.contains("shares"); });
  const double mass = number_of(page, "mass_kg");
  std::vector<std::string> titles{"Joint and motion", "peak moment (N&nbsp;m)"};
  if (mass > 0) titles.insert(titles.end(), {"by body mass (N&nbsp;m/kg)"});
  titles.insert(titles.end(), {"at&nbsp;(s)", "peak power&nbsp;(W)", "at&nbsp;(s)"});
  if (shares) titles.emplace_back("largest share of the variance");
  std::string table = fmt::format("<h3>Peaks</h3>\n<p class=\"quiet\">The values largest in size{}.</p>\n",
                                  deviations ? ", moments ± one standard deviation" : "");
  table += "<div class=\"scroll\"><table class=\"numbers peaks\">\n";
  table += table_head(titles);
  for (const json& c : all) {
    const json& peak = c["peak"];
    const double moment = number_of(peak, "moment"), deviation = number_of(peak, "deviation");
    std::vector<std::string> cells{with_deviation(moment, deviation)};
    if (mass > 0) cells.push_back(with_deviation(moment / mass, deviation / mass));
    cells.insert(cells.end(),
                 {fixed_text(number_of(peak, "time"), 2), significant_text(number_of(peak, "power"), 3),
                  fixed_text(number_of(peak, "power_time"), 2)});
    if (shares) cells.push_back(largest_cause(c));
    table += table_row(capital(text_of(c, "label")), cells);
  }
  return table + "</tbody></table></div>\n";
}

std::string advice_words(double percent) {
  if (!std::isfinite(percent)) return "–";
  if (percent > residual_advice) return fmt::format("<strong>above {} %</strong>", residual_advice);
  return fmt::format("within {} %", residual_advice);
}

std::string residual_rows(const json& residuals) {
  if (residuals.empty()) return "";
  std::string table = fmt::format(
      "<h3>Root residuals</h3>\n<p class=\"quiet\">Forces and moments that the root would need in addition "
      "to "
      "the measured ones. Hicks et al. (2015, J Biomech Eng 137:020905) advise residual forces below {} % of "
      "the "
      "peak external force.</p>\n<div class=\"scroll\"><table class=\"numbers residuals\">\n",
      residual_advice);
  table += table_head({"Root coordinate", "RMS", "peak", "of the peak force", "advice"});
  for (const json& r : residuals) {
    const double percent = number_of(r, "percent_of_peak_force");
    const std::string unit = html_text(text_of(r, "unit"));
    table += table_row(
        text_of(r, "coordinate"),
        {significant_text(number_of(r, "rms"), 3) + " " + unit,
         significant_text(number_of(r, "peak"), 3) + " " + unit,
         std::isfinite(percent) ? significant_text(percent, 2) + " %" : "–", advice_words(percent)});
  }
  return table + "</tbody></table></div>\n";
}

}  // namespace

Result<EffortSection> effort_section(const json& efforts) {
  if (const auto sound = check_efforts(efforts); !sound) return tl::unexpected(sound.error());
  EffortSection made{page_efforts(efforts), {}};
  const double mass = number_of(made.page, "mass_kg");
  made.html = fmt::format(
      "<section id=\"moments\" aria-labelledby=\"moments-title\">\n<h2 id=\"moments-title\">Joint "
      "moments</h2>\n"
      "<p class=\"quiet\">By inverse dynamics of {}{}. A moment is positive where it turns the joint in the "
      "named direction. Power is positive where muscles generate energy, negative where they absorb "
      "it.</p>\n",
      html_text(text_of(made.page, "source")),
      mass > 0 ? fmt::format(", body mass {}&nbsp;kg", fixed_text(mass, 1)) : "");
  made.html += peak_table(made.page) + residual_rows(made.page["residuals"]) + "</section>\n";
  return made;
}

}  // namespace borelli
