// The table's rows of the segments that are asked for, made of the rows of all parts.
//
// All parts are measured whatever is asked: what a part weighs depends on where its neighbours begin (skin,
// cut planes), and the sums are one pass. So a segment asked for alone has the numbers that it has in the
// whole table, and a group those of its parts, moved to their common centre (Huygens-Steiner).
#pragma once

#include <array>
#include <vector>

#include "inertia/table.hpp"
#include "pipeline/body/measure.hpp"
#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

/// The rows of all parts by what is known of them, by label as in parts.hpp: inertials (patient axes, m) and
/// volumes (m^3), framed by their landmarks.
std::vector<InertiaRow> rows_of_parts(const std::array<Inertial, parts.size()>& inertials,
                                      const std::array<double, parts.size()>& volumes,
                                      const Landmarks& landmarks);

/// A row for each segment of options.segments from the rows of all labels (by part); without a choice the
/// rows as they are. A group is whole where all of its parts are, absent where all are; its notes are its
/// parts', each with the part's name. Frames of groups by segment_frame.
std::vector<InertiaRow> rows_of_segments(std::vector<InertiaRow> all, const Landmarks& landmarks,
                                         const MeasureOptions& options);

/// The table of those rows. Its `whole` is the whole body whatever is asked: shares are of it.
InertiaTable table_of_segments(InertiaSource source, std::vector<InertiaRow> all, const Landmarks& landmarks,
                               const MeasureOptions& options);

}  // namespace borelli
