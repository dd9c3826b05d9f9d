// Checks for all readers whether a volume can be a scan of a person.
//
// Certain errors are refused, doubtful values give warnings. CT numbers are judged by where air (-1000) and
// soft tissue (-200 to 200) should be. Partial scans, children, MR and densities pass.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/quantity.hpp"
#include "segmentation/files/value_counts.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Checks the values of a volume read from `path` and adds doubts to `warnings`. Errors: impossible CT
/// numbers, with the likely cause.
Result<void> check_values(const std::string& path, const GreyVolume& volume, const ValueCounts& counts,
                          const Clamped& clamped, std::vector<std::string>& warnings);

/// Longest extent of a scan along an axis, mm: tall people are 2.5 m, scanners see less than 3 m.
inline constexpr double longest_scan = 3000;

/// A sentence about an unlikely voxel size; empty: none.
std::string doubt_of_size(const Grid& grid);

/// A sentence about an impossible mass, volume or density of a body; empty: none. `volume` in m^3; `mass` in
/// kg, 0: unknown. If the body is not `whole`, only too large a mass or volume is reported.
std::string doubt_of_body(double volume, double mass = 0, bool whole = true);

/// A part's share of an adult's mass: mean of men and women of de Leva (1996, J Biomech 29:1223, table 4).
/// Infinite if `part` is not a part.
double share_of_mass(std::string_view part);

/// Largest plausible volume of a part, m^3: its share (share_of_mass) of a body of 250 kg at the density of
/// water. Infinite if `name` is not a part.
double most_of_part(std::string_view name);

/// A sentence without subject if a part's volume exceeds most_of_part, e.g. because the scan's air was filled
/// with other values; else empty. `volume` in m^3.
std::string doubt_of_part(std::string_view name, double volume);

}  // namespace borelli
