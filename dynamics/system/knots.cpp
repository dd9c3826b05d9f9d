#include "dynamics/system/knots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/system/time_functions_of.hpp"

namespace borelli {

Knots::Knots(const System& system, const Parameters& parameters) {
  each_time_function(system, parameters, [this](const std::string&, const TimeFunction& f) {
    const auto* table = std::get_if<Table>(&f);
    if (!table || table->times.size() < 2) return;
    const bool again = table->ends == SplineEnds::periodic;
    Places& places = tables_.emplace_back();
    for (std::size_t i = 0; i + 1 < table->times.size(); ++i)
      for (const double part : {0., 0.5})
        places.times.push_back(table->times[i] + part * (table->times[i + 1] - table->times[i]));
    places.times.push_back(table->times.back());
    if (again) places.period = table->times.back() - table->times.front();
  });
}

double Knots::after(double t) const {
  double first = std::numeric_limits<double>::infinity();
  for (const Places& table : tables_) {
    // the earliest time that differs from t beyond rounding
    const double least =
        t + 16 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), table.period);
    const double round =
        table.period > 0 ? table.period * std::floor((least - table.times.front()) / table.period) : 0;
    auto at = std::upper_bound(table.times.begin(), table.times.end(), least - round);
    // (otherwise rounding put it at the end of a period)
    if (at != table.times.end())
      first = std::min(first, *at + round);
    else if (table.period > 0)
      first = std::min(first, table.times[1] + round + table.period);
  }
  return first;
}

double Knots::count(double start, double end) const {
  double sum = 0;
  for (const Places& table : tables_)
    sum += double(table.times.size()) * (table.period > 0 ? std::ceil((end - start) / table.period) : 1);
  return sum;
}

}  // namespace borelli
