// Sorts slices, makes their grid and checks that they are evenly spaced.
//
// Slices are sorted by position along their normal. Neighbours may also be shifted sideways, as with a tilted
// gantry. The third axis of the grid is the true step from slice to slice, so that a tilt shears the grid.
// Positions are rounded decimals: the grid follows the straight line of best fit. Slices are even if each
// position lies on this line within its rounding error.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/files/dicom_slice.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct SliceStack {
  std::vector<DicomSlice> slices;  ///< in the order of the grid's k, before any is filled in
  Grid grid;                       ///< evenly spaced
  /// Where each of the grid's slices lies among `slices`: 2.25 is a quarter of the way from slice 2 to
  /// slice 3. Empty where they are the same.
  std::vector<double> sources;
  /// Tilt, missing slices, uneven spacing, other fields that contradict the positions: one sentence each.
  std::vector<std::string> notes;
};

/// Orders slices of one series and one orientation. Errors: fewer than two, two different ones at one
/// position, slices that are not in one line, gaps too wide to fill, two fields that contradict the positions.
Result<SliceStack> stack_slices(const std::string& where, std::vector<DicomSlice> slices);

/// Sorts slices by their places along the normal of the first one.
void sort_along(std::vector<DicomSlice>& slices);

/// The number of slices missing among evenly spaced slices of one orientation. Nothing if the spacing is
/// uneven or two slices are at one place.
std::optional<std::int64_t> missing_slices(const std::vector<DicomSlice>& slices);

/// Whether slices of one orientation lie on a straight line, at two places or more.
bool in_one_line(const std::vector<DicomSlice>& slices);

/// Positions closer than this are the same (mm).
inline constexpr double same_place = 1e-3;

}  // namespace borelli
