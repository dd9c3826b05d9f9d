#include "inertia/density.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "inertia/csv.hpp"

namespace borelli {
namespace data {
extern const char* const hu_density;
}

double DensityCurve::at(double hu) const {
  if (hu <= knots.front()[0]) return knots.front()[1];
  if (hu >= knots.back()[0]) return knots.back()[1];
  const auto next = std::upper_bound(knots.begin(), knots.end(), hu,
                                     [](double x, const auto& knot) { return x < knot[0]; });
  const Eigen::Vector2d &a = *(next - 1), &b = *next;
  return a[1] + (hu - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
}

const std::vector<DensityCurve>& density_curves() {
  static const auto curves = [] {
    const CsvTable table = parse_csv(data::hu_density, "hu_density.csv").value();
    std::vector<DensityCurve> list;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const std::string& name = table.field(row, "curve");
      if (list.empty() || list.back().name != name) {
        list.push_back({name, "", {}});
        for (const std::string& comment : table.comments)
          if (comment.starts_with(name + ": ")) list.back().source = comment.substr(name.size() + 2);
      }
      list.back().knots.emplace_back(table.number(row, "hu"), table.number(row, "density_kgm3"));
    }
    return list;
  }();
  return curves;
}

Result<DensityCurve> density_curve(std::string_view name) {
  std::vector<std::string> names;
  for (const auto& curve : density_curves()) {
    if (curve.name == name) return curve;
    names.push_back(curve.name);
  }
  return bad_use("density curve",
                 fmt::format("unknown curve '{}'; choose one of: {}", name, fmt::join(names, ", ")));
}

Result<GreyWeights> density_weights(Quantity quantity, const DensityCurve& curve, BelowAir below) {
  if (quantity != Quantity::hu && quantity != Quantity::density_kgm3)
    return bad_use("density", fmt::format("{} do not give densities; give CT numbers (hu) or densities",
                                          quantity == Quantity::mr ? "MR signals" : "labels"));
  const auto weight = [&](int grey) -> double {
    if (quantity == Quantity::density_kgm3) return std::max(grey, 0);
    if (grey >= -1000 || below == BelowAir::hold) return curve.at(grey);
    constexpr int below_noise = -1500;  // noise about air does not reach it
    if (grey < below_noise) return 0;   // padding: its density is unknown
    return curve.at(-1000) + (curve.at(-900) - curve.at(-1000)) / 100 * (grey + 1000);
  };
  GreyWeights weights(65536);
  for (int grey = -32768; grey < 32768; ++grey)
    weights[static_cast<std::size_t>(grey + 32768)] = weight(grey);
  return weights;
}

}  // namespace borelli
