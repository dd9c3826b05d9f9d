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
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct DicomSegmentation {
  Grid grid;                                  ///< from the first to the last frame's place, evenly spaced
  std::vector<std::uint16_t> numbers;         ///< #grid.count() segment numbers, 0: none
  std::map<std::int64_t, std::string> names;  ///< segment labels, by number
  std::map<std::int64_t, std::vector<std::string>> other_names;  ///< by their coded terminology
};

/// True for a DICOM file, whatever it holds.
bool is_dicom_file(const std::string& path);

/// Reads a segmentation: a file, or a folder that holds exactly one. A fractional segment claims a pixel from
/// half of the maximum on. If several claim it, the largest fraction wins, then the larger number. `accept`
/// checks the grid before voxels are allocated; its error is passed on.
/// Errors: no segmentation; frames without place or segment, out of line, unevenly spaced or longer than any
/// body; packed binary frames; fewer pixels than frames; more than fits into memory.
Result<DicomSegmentation> read_dicom_segmentation(
    const std::string& path, const std::function<Result<void>(const Grid&)>& accept = {});

/// A sentence where scan and labels (files or folders) are both DICOM and name frames of reference
/// (0020,0052) that are not the same: their coordinates need not mean the same places. Else empty.
std::string doubt_of_frames(const std::string& scan, const std::string& labels);

}  // namespace borelli
