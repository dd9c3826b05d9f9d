#include "pipeline/charts/page_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "pipeline/charts/page_frame.hpp"
#include "pipeline/charts/plot_scale.hpp"
#include "pipeline/charts/plot_style.hpp"

namespace borelli {
namespace {

using nlohmann::json;

/// Six digits: finer than a pixel, and a third of the bytes. Null: not finite.
json drawn_number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

/// Each tip once, as plots of other costs repeat them.
class PageTips {
 public:
  json index(const std::string& tip) {
    if (tip.empty()) return nullptr;
    const auto [at, fresh] = known_.try_emplace(tip, list.size());
    if (fresh) list.push_back(tip);
    return at->second;
  }
  json list = json::array();

 private:
  std::map<std::string, std::size_t> known_;
};

json axis_json(const Axis& axis, const PlotScale& scale) {
  json made{{"label", axis.label},
            {"log", scale.logarithmic},
            {"low", drawn_number(scale.low)},
            {"high", drawn_number(scale.high)}};
  if (axis.whole_numbers) made["whole"] = true;
  if (!axis.ticks.empty()) made["ticks"] = axis.ticks;
  return made;
}

json curve_json(const Curve& curve, const CurveStyle& style, bool shown, PageTips& tips) {
  json made{{"name", curve.name}, {"x", json::array()},   {"y", json::array()}, {"colour", style.colour},
            {"dash", style.dash}, {"shape", style.shape}, {"shown", shown}};
  if (curve.marks) made["marks"] = true;
  if (curve.broad) made["broad"] = true;
  for (std::size_t i = 0; i < std::min(curve.x.size(), curve.y.size()); ++i) {
    made["x"].push_back(drawn_number(curve.x[i]));
    made["y"].push_back(drawn_number(curve.y[i]));
    if (i < curve.tips.size()) made["tips"].push_back(tips.index(curve.tips[i]));
    if (i < curve.hollow.size() && curve.hollow[i]) made["hollow"].push_back(i);
  }
  return made;
}

json plot_json(Plot plot, PageTips& tips) {
  const std::vector<bool> shown = shown_at_first(plot);
  const bool marks = std::ranges::any_of(plot.curves, &Curve::marks);
  json made{{"title", plot.title},
            {"x", axis_json(plot.x, scale_of(plot.x, plot.curves, &Curve::x, 8, marks ? 0.02 : 0))},
            {"y", axis_json(plot.y, scale_of(plot.y, plot.curves, &Curve::y, 6, 0.03))},
            {"curves", json::array()},
            {"notes", plot.notes}};
  for (Curve& curve : plot.curves) curve.faint = false;  // one that is asked for has a colour
  const std::vector<CurveStyle> styles = curve_styles(plot);
  for (std::size_t i = 0; i < plot.curves.size(); ++i)
    made["curves"].push_back(curve_json(plot.curves[i], styles[i], shown[i], tips));
  for (const EdgeMark& mark : plot.edge)
    made["edge"].push_back(
        {{"x", drawn_number(mark.x)}, {"curve", mark.curve}, {"tip", tips.index(mark.tip)}});
  for (const Tile& tile : plot.tiles)
    made["tiles"].push_back({drawn_number(tile.x_low), drawn_number(tile.x_high), drawn_number(tile.y_low),
                             drawn_number(tile.y_high), tile.kind, tips.index(tile.tip)});
  for (std::size_t kind = 0; kind < plot.kinds.size(); ++kind)
    made["kinds"].push_back({{"name", plot.kinds[kind]},
                             {"colour", tile_fills.at(kind).colour},
                             {"hatch", tile_fills.at(kind).hatch}});
  return made;
}

/// The tips are in the data already.
Plot without_tips(Plot plot) {
  for (Curve& curve : plot.curves) curve.tips.clear();
  for (EdgeMark& mark : plot.edge) mark.tip.clear();
  for (Tile& tile : plot.tiles) tile.tip.clear();
  return plot;
}

}  // namespace

std::vector<bool> shown_at_first(const Plot& plot) {
  std::vector<bool> shown(plot.curves.size());
  std::vector<std::pair<std::size_t, std::size_t>> order;  // place within its group, place in the plot
  std::map<std::string, std::size_t> members;
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    const Curve& curve = plot.curves[i];
    shown[i] = curve.broad;
    if (!curve.broad && !curve.faint) order.emplace_back(curve.group.empty() ? 0 : members[curve.group]++, i);
  }
  std::ranges::sort(order);
  for (std::size_t i = 0; i < std::min(order.size(), curves_at_first); ++i) shown[order[i].second] = true;
  return shown;
}

std::string page_plots(const std::vector<PagePlot>& plots) {
  std::string figures;
  PageTips tips;
  json list = json::array();
  for (const PagePlot& one : plots) {
    figures += "<figure class=\"plot\"";
    for (const auto& [kind, value] : one.choice)
      figures += fmt::format(" data-{}=\"{}\"", kind, html_text(value));
    figures += "><div class=\"static scroll\">" + svg(without_tips(one.plot)) + "</div></figure>\n";
    list.push_back(plot_json(one.plot, tips));
  }
  return figures + "<script type=\"application/json\" id=\"plots\">" +
         script_json({{"tips", tips.list}, {"plots", list}}) + "</script>\n";
}

}  // namespace borelli
