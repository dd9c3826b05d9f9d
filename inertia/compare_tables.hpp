// Tables of several bodies, or of one body measured twice, beside each other: differences of two, means and
// regressions of many.
//
// Parts are taken whole only: a cut one does not compare. Entries that say where the body lay (patient axes)
// are left out.
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

/// Whether the tables' parts are the same things: cut by one convention, axes by one way. Error: in words,
/// which table differs in what.
Result<void> check_comparable(const std::vector<NamedTable>& tables);

/// What does compare but with a grain of salt, in words: other density curves, samplings, poses.
std::vector<std::string> remarks_on(const std::vector<NamedTable>& tables);

/// An entry (see entries.hpp) of one part in two tables.
struct TableDifference {
  std::string part, entry;
  double first = 0, second = 0;
  /// Standard deviation of their difference, those of both tables taken as independent; nothing where one has
  /// none.
  std::optional<double> deviation;
  double percent() const { return 100 * (second / first - 1); }
};
std::vector<TableDifference> differences(const InertiaTable& first, const InertiaTable& second);

/// entry = intercept + per_metre stature + per_kilogram mass, by least squares.
struct TableRegression {
  int bodies = 0;
  double intercept = 0, per_metre = 0, per_kilogram = 0;
  double r2 = 0;           ///< share of the variance that it explains
  double residual_sd = 0;  ///< with bodies - 3 degrees of freedom
};

/// An entry of one part over many tables.
struct GroupEntry {
  std::string part, entry;
  int bodies = 0;  ///< that have it
  double mean = 0;
  double sd = 0;  ///< between bodies, with bodies - 1 degrees of freedom
  std::optional<TableRegression> regression;
};
struct GroupTable {
  std::vector<GroupEntry> entries;
  std::string no_regression;  ///< why there is none; empty where there is
};
GroupTable group_of(const std::vector<NamedTable>& tables);

/// Two tables: their differences; more: the group. With comments that say of what.
std::string comparison_csv(const std::vector<NamedTable>& tables);
std::string comparison_json(const std::vector<NamedTable>& tables);

}  // namespace borelli
