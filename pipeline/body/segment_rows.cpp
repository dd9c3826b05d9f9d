#include "pipeline/body/segment_rows.hpp"

#include <algorithm>

#include "pipeline/body/isb_frames.hpp"
#include "pipeline/body/segment_frames.hpp"

namespace borelli {
namespace {

InertiaRow merged(const Segment& segment, const std::vector<const InertiaRow*>& of,
                  const Landmarks& landmarks, const MeasureOptions& options) {
  InertiaRow row;
  row.part = segment.name;
  const auto is = [](Completeness completeness) {
    return [completeness](const InertiaRow* part) { return part->completeness == completeness; };
  };
  row.completeness = std::ranges::all_of(of, is(Completeness::whole))    ? Completeness::whole
                     : std::ranges::all_of(of, is(Completeness::absent)) ? Completeness::absent
                                                                         : Completeness::cut;
  for (const InertiaRow* part : of) {
    for (const auto& note : part->notes) row.notes.push_back(part->part + ": " + note);
    if (part->completeness == Completeness::absent) {
      if (row.completeness != Completeness::absent) row.notes.push_back(part->part + ": absent");
      continue;
    }
    row.volume += part->volume;
    row.inertial += part->inertial;
  }
  if (row.completeness == Completeness::absent) return row;
  row.frame = segment_frame(row.part, landmarks, row.inertial, options.cuts);
  if (row.frame && options.frames == "isb") lay_isb_frame(*row.frame, row.part, landmarks);
  return row;
}

}  // namespace

std::vector<InertiaRow> rows_of_parts(const std::array<Inertial, parts.size()>& inertials,
                                      const std::array<double, parts.size()>& volumes,
                                      const Landmarks& landmarks) {
  std::vector<InertiaRow> rows;
  for (std::size_t label = 1; label < parts.size(); ++label) {
    InertiaRow row;
    row.part = parts[label].name;
    row.volume = volumes[label];
    row.inertial = inertials[label];
    row.frame = segment_frame(row.part, landmarks, row.inertial);
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<InertiaRow> rows_of_segments(std::vector<InertiaRow> all, const Landmarks& landmarks,
                                         const MeasureOptions& options) {
  if (options.segments.empty()) return all;
  std::vector<InertiaRow> rows;
  for (const Segment& segment : options.segments) {
    std::vector<const InertiaRow*> of;
    for (const InertiaRow& row : all)
      if (std::ranges::find(segment.of, row.part) != segment.of.end()) of.push_back(&row);
    if (of.size() == 1 && of.front()->part == segment.name)
      rows.push_back(*of.front());
    else
      rows.push_back(merged(segment, of, landmarks, options));
  }
  return rows;
}

InertiaTable table_of_segments(InertiaSource source, std::vector<InertiaRow> all, const Landmarks& landmarks,
                               const MeasureOptions& options) {
  if (options.segments.empty()) return make_table(std::move(source), std::move(all));
  const InertiaTable body = make_table(source, all);
  InertiaTable table = make_table(std::move(source), rows_of_segments(std::move(all), landmarks, options));
  table.whole = body.whole;
  return table;
}

}  // namespace borelli
