// Table rows of the requested segments, made from the rows of all parts.
//
// All parts are always measured: a part's mass depends on its neighbours' borders (skin, cut planes), and the
// sums take one pass. So a segment requested alone has the same numbers as in the whole table. A group has
// the numbers of its parts, moved to their common centre (Huygens-Steiner).
#pragma once

#include <array>
#include <vector>

#include "inertia/table.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// Rows of all parts, by label as in parts.hpp, from inertials (patient axes, m) and volumes (m^3), with
/// frames by the landmarks.
std::vector<InertiaRow> rows_of_parts(const std::array<Inertial, parts.size()>& inertials,
                                      const std::array<double, parts.size()>& volumes,
                                      const Landmarks& landmarks);

/// One row for each segment in options.segments, from the rows of all labels (by part); without a choice the
/// rows unchanged. A group is whole if all of its parts are, absent if all are. Its notes are its parts'
/// notes, each with the part's name. Groups get their frames from segment_frame.
std::vector<InertiaRow> rows_of_segments(std::vector<InertiaRow> all, const Landmarks& landmarks,
                                         const MeasureOptions& options);

/// Table of those rows. Its `whole` is always the whole body: shares refer to it.
InertiaTable table_of_segments(InertiaSource source, std::vector<InertiaRow> all, const Landmarks& landmarks,
                               const MeasureOptions& options);

}  // namespace borelli
