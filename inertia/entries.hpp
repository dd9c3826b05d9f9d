// The numbers of a table's row by name: columns of the table's CSV, and subjects of deviations and
// comparisons.
#pragma once

#include <string>
#include <vector>

#include "inertia/table.hpp"

namespace borelli {

struct Entry {
  std::string name;         ///< with its unit, e.g. "mass_kg", "anatomical_Ixy_kgm2", "centre_pct"
  double value = 0;         ///< NaN if not known
  bool of_the_body = true;  ///< false: it also depends on how the body lay (patient axes)
};

/// Always the same names in the same order: volume, mass and its share, gravity centre and tensor in patient
/// axes, tensor in anatomical axes, principal moments, length, position of the gravity centre along it, radii
/// of gyration.
std::vector<Entry> entries_of(const InertiaTable& table, const InertiaRow& row);

}  // namespace borelli
