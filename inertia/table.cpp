#include "inertia/table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

namespace borelli {

std::string_view name_of(Completeness completeness) {
  switch (completeness) {
    case Completeness::absent:
      return "absent";
    case Completeness::cut:
      return "cut";
    case Completeness::whole:
      break;
  }
  return "whole";
}

InertiaTable make_table(InertiaSource source, std::vector<InertiaRow> rows) {
  InertiaTable table{std::move(source), {}, std::move(rows), {}};
  table.whole.part = "body";
  const auto find_flaw = [](InertiaRow& row) {
    const auto physical = check_physical(row.inertial, row.part);
    row.flaw = physical ? "" : physical.error().what;
  };
  for (InertiaRow& row : table.rows) {
    table.whole.completeness = std::min(table.whole.completeness, row.completeness);
    if (row.completeness == Completeness::absent) continue;
    find_flaw(row);
    table.whole.inertial += row.inertial;
    table.whole.volume += row.volume;
  }
  if (table.whole.completeness == Completeness::absent) table.whole.completeness = Completeness::cut;
  if (table.whole.inertial.mass == 0) table.whole.completeness = Completeness::absent;
  if (table.whole.completeness != Completeness::absent) find_flaw(table.whole);
  return table;
}

std::optional<AnatomicalNumbers> anatomical_numbers(const InertiaRow& row) {
  if (!row.frame || row.completeness == Completeness::absent) return std::nullopt;
  const SegmentFrame& frame = *row.frame;
  AnatomicalNumbers numbers;
  numbers.tensor = frame.R_WA.transpose() * row.inertial.tensor * frame.R_WA;
  numbers.length = frame.length();
  if (numbers.length > 0) {
    numbers.centre_along = frame.long_axis.dot(row.inertial.centre - frame.from_point) / numbers.length;
    numbers.radii = row.inertial.radii_of_gyration(frame.R_WA) / numbers.length;
  } else {
    numbers.length = 0;
    numbers.centre_along = std::numeric_limits<double>::quiet_NaN();
    numbers.radii.setConstant(numbers.centre_along);
  }
  return numbers;
}

Comparison compare(const InertiaTable& table, const InertiaRow& row, std::string_view published_table) {
  const std::string& sex = table.source.sex;
  const auto none = [](std::string why) { return Comparison{.why_not = std::move(why)}; };
  if (sex.empty()) return none("the sex is not stated");
  if (row.completeness != Completeness::whole)
    return none(fmt::format("the part is {}", name_of(row.completeness)));
  if (!row.frame || row.frame->length() <= 0) return none("the endpoints are unknown");
  const SegmentFrame& frame = *row.frame;
  const bool whole = table.whole.completeness == Completeness::whole;
  if (const auto* same =
          published_segment(published_table, sex, frame.segment, frame.from, frame.to, frame.cuts)) {
    // radii refer to axes: joint-based axes match the published ones
    const bool own_axes = table.source.frames == "isb" && !frame.origin_name.empty();
    return {same, whole, !own_axes, own_axes ? "mass only: the axes are the ISB's" : ""};
  }
  if (const auto* mass = published_segment(published_table, sex, frame.segment, "", "", frame.cuts))
    return {mass, whole, false,
            mass->from.empty()
                ? "mass only: the publication names no endpoints"
                : fmt::format("mass only: the published endpoints are {}-{}", mass->from, mass->to)};
  return none(fmt::format("not comparable: nothing is published for the cuts {}", frame.cuts));
}

}  // namespace borelli
