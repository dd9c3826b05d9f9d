#include "pipeline/body/joint_ranges.hpp"

#include <numbers>
#include <sstream>
#include <utility>

namespace borelli {
namespace data {
extern const char* const joint_ranges;
}

const std::map<std::string, Range>& joint_ranges() {
  static const auto ranges = [] {
    std::map<std::string, Range> table;
    std::istringstream lines(data::joint_ranges);
    bool header = true;
    for (std::string line; std::getline(lines, line);) {
      if (line.empty() || line.front() == '#') continue;
      if (std::exchange(header, false)) continue;
      std::istringstream row(line);
      std::string joint, axis, lower, upper;
      std::getline(row, joint, ','), std::getline(row, axis, ','), std::getline(row, lower, ',');
      std::getline(row, upper, ',');
      constexpr double degree = std::numbers::pi / 180;
      table[joint + " " + axis] = {std::stod(lower) * degree, std::stod(upper) * degree};
    }
    return table;
  }();
  return ranges;
}

}  // namespace borelli
