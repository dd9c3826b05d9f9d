// DICOM-SEG: the segments of a segmentation object as one label map.
//
// PS3.3, A.51 and C.8.20: each frame is one slice of one segment, binary (a bit a pixel) or fractional (the
// share or likelihood of it in a pixel), or, in a label map, of all. Frames without anything may be left out.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

struct DicomSegmentation {
  Grid grid;                                  ///< from the first to the last frame's place, evenly spaced
  std::vector<std::uint16_t> numbers;         ///< #grid.count() segment numbers, 0: none
  std::map<std::int64_t, std::string> names;  ///< segment labels, by number
};

/// True for a DICOM file, whatever it holds.
bool is_dicom_file(const std::string& path);

/// Reads a segmentation: a file, or a folder that holds one and no other. A fractional segment has a pixel
/// from half of the most on; of several that would have it, the one with the largest fraction has it, of
/// equals the one with the larger number. Errors: no segmentation, frames without a place or a segment, out
/// of line, unevenly spaced or longer than any body, packed binary frames; fewer pixels than frames; more
/// than fits into memory.
/// `accept` is asked about the grid before memory is taken for it.
Result<DicomSegmentation> read_dicom_segmentation(
    const std::string& path, const std::function<Result<void>(const Grid&)>& accept = {});

/// A sentence where scan and labels (files or folders) are both DICOM and name frames of reference
/// (0020,0052) that are not the same: their coordinates need not mean the same places. Else empty.
std::string doubt_of_frames(const std::string& scan, const std::string& labels);

}  // namespace borelli
