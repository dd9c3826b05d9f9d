// Slices in order: their grid, and whether they are evenly spaced.
//
// Positions are ordered along the normal of the slices. Neighbours may also be shifted sideways, as behind a
// tilted gantry: the third axis of the grid is the true step from slice to slice, so that a tilt is a shear
// of the grid, not an error in it.
#pragma once

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
  std::vector<std::string> notes;  ///< tilt, missing slices, uneven spacing, doubles: one sentence each
};

/// Orders slices of one series and one orientation. Errors: fewer than two, two different ones at one
/// position, slices that are not in one line, gaps too wide to fill.
Result<SliceStack> stack_slices(const std::string& where, std::vector<DicomSlice> slices);

}  // namespace borelli
