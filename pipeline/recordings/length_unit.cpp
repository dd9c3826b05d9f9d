#include "pipeline/recordings/length_unit.hpp"

#include <algorithm>
#include <array>

#include "segmentation/files/header_text.hpp"

namespace borelli {
namespace {

struct Unit {
  std::string_view sign, name, american;
  double per_metre;
};
// The inch is 0.0254 m and the foot 0.3048 m by definition (international yard and pound agreement, 1959).
constexpr std::array units_of_length{Unit{"m", "metre", "meter", 1},
                                     Unit{"dm", "decimetre", "decimeter", 10},
                                     Unit{"cm", "centimetre", "centimeter", 100},
                                     Unit{"mm", "millimetre", "millimeter", 1000},
                                     Unit{"um", "micrometre", "micrometer", 1e6},
                                     Unit{"in", "inch", "inche", 1 / 0.0254},
                                     Unit{"ft", "foot", "feet", 1 / 0.3048}};

}  // namespace

std::optional<double> per_metre(std::string_view unit) {
  std::string word = lower_case(trimmed(unit));
  const auto found = std::ranges::find(units_of_length, word, &Unit::sign);
  if (found != units_of_length.end()) return found->per_metre;
  if (word.size() > 2 && word.ends_with('s')) word.pop_back();
  for (const Unit& known : units_of_length)
    if (word == known.name || word == known.american) return known.per_metre;
  return std::nullopt;
}

}  // namespace borelli
