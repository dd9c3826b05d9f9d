#include "pipeline/charts/ladder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace borelli {
namespace {

constexpr int most_values = 1000;

std::vector<std::string> parts_of(const std::string& text, char between) {
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(between, begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

Result<Ladder> parse_ladder(const std::string& text, const std::string& what, int count) {
  const auto refuse = [&] {
    return bad_use(what, fmt::format("is '{}'; expected LOW:HIGH, LOW:HIGH:COUNT (2 to {}), "
                                     "LOW:HIGH:COUNT:log or :linear, or values separated by commas",
                                     text, most_values));
  };
  std::vector<std::string> parts = parts_of(text, ':');
  if (parts.size() == 1) {
    Ladder ladder;
    for (const std::string& part : parts_of(text, ',')) {
      const auto value = number_of(part);
      if (!value) return refuse();
      ladder.values.push_back(*value);
    }
    std::sort(ladder.values.begin(), ladder.values.end());
    ladder.values.erase(std::unique(ladder.values.begin(), ladder.values.end()), ladder.values.end());
    ladder.logarithmic = ladder.values.front() > 0 && ladder.values.back() >= 10 * ladder.values.front();
    return ladder;
  }
  const auto low = number_of(parts[0]), high = number_of(parts[1]);
  if (parts.size() > 4 || !low || !high || !(*low < *high)) return refuse();
  Ladder ladder{{}, *low > 0 && *high >= 10 * *low};
  if (parts.size() == 4) {
    if (parts[3] != "log" && parts[3] != "linear") return refuse();
    ladder.logarithmic = parts[3] == "log";
    if (ladder.logarithmic && !(*low > 0)) return refuse();
  }
  if (parts.size() > 2) {
    const auto given = number_of(parts[2]);
    if (!given || *given != std::floor(*given) || *given < 2 || *given > most_values) return refuse();
    count = int(*given);
  } else if (ladder.logarithmic) {
    count = std::min(count, 1 + int(std::ceil(4 * std::log10(*high / *low) - 1e-9)));
  }
  for (int i = 0; i < count; ++i) {
    const double share = double(i) / (count - 1);
    const double value =
        ladder.logarithmic ? *low * std::pow(*high / *low, share) : *low + share * (*high - *low);
    // rounded as a person would write it
    ladder.values.push_back(i == 0           ? *low
                            : i == count - 1 ? *high
                                             : std::stod(fmt::format("{:.12g}", value)));
  }
  return ladder;
}

std::vector<double> tile_bounds(const Ladder& ladder) {
  const std::vector<double>& v = ladder.values;
  const auto middle = [&](double a, double b) { return ladder.logarithmic ? std::sqrt(a * b) : (a + b) / 2; };
  // a single value: as if its neighbours were twice and half of it, or one unit away
  if (v.size() == 1)
    return ladder.logarithmic ? std::vector{v[0] / std::sqrt(2.), v[0] * std::sqrt(2.)}
                              : std::vector{v[0] - 0.5, v[0] + 0.5};
  std::vector<double> out(v.size() + 1);
  for (std::size_t i = 1; i < v.size(); ++i) out[i] = middle(v[i - 1], v[i]);
  const auto beyond = [&](double at, double inner) {
    return ladder.logarithmic ? at * at / inner : 2 * at - inner;
  };
  out.front() = beyond(v.front(), out[1]);
  out.back() = beyond(v.back(), out[v.size() - 1]);
  return out;
}

}  // namespace borelli
