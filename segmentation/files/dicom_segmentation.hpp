// Reads the segments of a DICOM segmentation object (DICOM-SEG) as one label map.
//
// PS3.3, A.51 and C.8.20: each frame is one slice of one segment. It is binary (one bit per pixel) or
// fractional (the segment's share or probability in a pixel). In a label map, each frame is a slice of all
// segments. Empty frames may be left out.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/segment_overlaps.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct DicomSegmentation {
  Grid grid;                                  ///< from the first to the last frame's place, evenly spaced
  std::vector<std::uint16_t> numbers;         ///< #grid.count() segment numbers, 0: none
  std::map<std::int64_t, std::string> names;  ///< segment labels, by number
  std::map<std::int64_t, std::vector<std::string>> other_names;  ///< by their coded terminology
  std::vector<std::string> warnings;
};

/// True for a DICOM file, whatever it holds.
bool is_dicom_file(const std::string& path);

/// Reads a segmentation: a file, or a folder that holds exactly one. A fractional segment claims a pixel from
/// half of the maximum on. If several claim it that are equally used, the largest fraction wins; otherwise
/// SegmentOverlaps decides. `names` replace the file's. `accept` checks the grid before voxels are allocated;
/// its error is passed on. Errors: not a segmentation; frames without position or segment, not in one line,
/// unevenly spaced or longer than any body; packed binary frames; fewer pixels than the frames need; those of
/// SegmentOverlaps; out of memory.
Result<DicomSegmentation> read_dicom_segmentation(const std::string& path,
                                                  const std::function<Result<void>(const Grid&)>& accept = {},
                                                  const IsUsed& is_used = {},
                                                  const std::map<std::int64_t, std::string>* names = nullptr);

/// A warning if scan and labels (files or folders) are both DICOM and their frames of reference (0020,0052)
/// differ: their coordinates may not match. Else empty.
std::string doubt_of_frames(const std::string& scan, const std::string& labels);

}  // namespace borelli
