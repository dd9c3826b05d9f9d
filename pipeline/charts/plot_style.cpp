#include "pipeline/charts/plot_style.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace borelli {
namespace {

constexpr std::array<std::string_view, 7> colours{"#0072B2", "#D55E00", "#000000", "#009E73",
                                                  "#CC79A7", "#E69F00", "#56B4E9"};
constexpr std::array<std::string_view, 7> dashes{"none", "8 3", "2 2", "10 3 2 3", "5 2", "12 4", "1 3"};

}  // namespace

std::vector<CurveStyle> curve_styles(const Plot& plot) {
  std::vector<CurveStyle> styles;
  std::vector<std::pair<std::string, std::size_t>> groups;  // name, and number of its curves so far
  std::size_t alone = 0;
  for (const Curve& curve : plot.curves) {
    if (curve.broad) {
      styles.push_back({"#F5EDA0", "none"});
    } else if (curve.faint) {
      styles.push_back({"#C4C4C4", "none"});
    } else if (curve.group.empty()) {
      const std::size_t number = alone++;
      styles.push_back({colours[number % colours.size()],
                        dashes[(number + number / colours.size()) % dashes.size()],
                        int(std::min<std::size_t>(number / colours.size(), 2))});
    } else {
      auto group = std::ranges::find(groups, curve.group, &std::pair<std::string, std::size_t>::first);
      if (group == groups.end()) group = groups.insert(groups.end(), {curve.group, 0});
      const std::size_t number = group->second++;
      styles.push_back({colours[std::size_t(group - groups.begin()) % colours.size()],
                        dashes[number % dashes.size()], int(number % 3)});
    }
  }
  return styles;
}

}  // namespace borelli
