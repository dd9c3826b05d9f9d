// Units of length as motion files name them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace borelli {

/// How many of the unit make a metre: 1000 for "mm". Dividing by it keeps all digits of a decimal in mm.
/// Knows m, dm, cm, mm, um, in, ft, their English names in singular and plural (also "-meter"), in any letter
/// case. Empty: another word.
std::optional<double> per_metre(std::string_view unit);

/// For messages: the units that per_metre knows.
inline constexpr std::string_view length_units = "m, dm, cm, mm, um, in or ft";

}  // namespace borelli
