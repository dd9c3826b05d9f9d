// Compares inertia tables of several bodies, or of one body measured twice: differences of two, means and
// regressions of many.
//
// Only whole parts are compared, not cut ones. Entries that depend on where the body lay (patient axes) are
// left out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "inertia/table.hpp"

namespace borelli {

struct NamedTable {
  std::string name;  ///< of its file
  InertiaTable table;
};

/// Checks that the tables' parts are comparable: same convention of cuts, same kind of axes. Error: which
/// table differs in what.
Result<void> check_comparable(const std::vector<NamedTable>& tables);

/// Sentences on what limits the comparison: different density curves, samplings, poses.
std::vector<std::string> remarks_on(const std::vector<NamedTable>& tables);

/// An entry (see entries.hpp) of one part in two tables.
struct TableDifference {
  std::string part, entry;
  double first = 0, second = 0;
  /// Standard deviation of the difference, with the tables' deviations taken as independent; empty if one is
  /// missing.
  std::optional<double> deviation;
  double percent() const { return 100 * (second / first - 1); }
};
/// Of each part that is whole in both tables, the entries known in both: by part, then in the order of
/// entries_of.
std::vector<TableDifference> differences(const InertiaTable& first, const InertiaTable& second);

/// entry = intercept + per_metre stature + per_kilogram mass, by least squares.
struct TableRegression {
  int bodies = 0;
  double intercept = 0, per_metre = 0, per_kilogram = 0;
  double r2 = 0;           ///< explained share of the variance
  double residual_sd = 0;  ///< with bodies - 3 degrees of freedom
};

/// An entry of one part over many tables.
struct GroupEntry {
  std::string part, entry;
  int bodies = 0;  ///< number of bodies that have it
  double mean = 0;
  double sd = 0;  ///< between bodies, with bodies - 1 degrees of freedom
  std::optional<TableRegression> regression;
};
struct GroupTable {
  std::vector<GroupEntry> entries;
  std::string no_regression;  ///< why there is no regression; empty: there is one
};
/// Over the tables in which a part is whole: by part, then in the order of entries_of. A regression needs the
/// stature and the whole body's mass.
GroupTable group_of(const std::vector<NamedTable>& tables);

/// Two tables: their differences; more: the group. Comments state the tables.
std::string comparison_csv(const std::vector<NamedTable>& tables);
std::string comparison_json(const std::vector<NamedTable>& tables);

}  // namespace borelli
