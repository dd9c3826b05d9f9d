// Slices in order: their grid, and whether they are evenly spaced.
//
// Positions are ordered along the normal of the slices. Neighbours may also be shifted sideways, as behind a
// tilted gantry: the third axis of the grid is the true step from slice to slice, so that a tilt is a shear
// of the grid, not an error in it. Positions are decimals that somebody rounded: the grid is the straight
// line that fits all of them best, and slices are even if no position is further off one than its text is
// rounded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/dicom_slice.hpp"
#include "segmentation/volume.hpp"

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
/// position, slices that are not in one line, gaps too wide to fill.
Result<SliceStack> stack_slices(const std::string& where, std::vector<DicomSlice> slices);

/// By their places along the normal of the first one.
void sort_along(std::vector<DicomSlice>& slices);

/// How many slices are missing between slices of one orientation that otherwise lie evenly; nothing where
/// they do not, or two are at one place.
std::optional<std::int64_t> missing_slices(const std::vector<DicomSlice>& slices);

/// Whether slices of one orientation, of which there are two places at least, lie behind each other.
bool in_one_line(const std::vector<DicomSlice>& slices);

/// Two positions closer than this are one (mm).
inline constexpr double same_place = 1e-3;

}  // namespace borelli
