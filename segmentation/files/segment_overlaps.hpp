// Segments that overlap, as layers of 3D Slicer, DICOM-SEG and folders of masks allow: one rule for all.
//
// A used segment keeps its voxels against one that is not used, as a tumour or the whole body. Between equals
// the later segment gets the voxel, as in 3D Slicer.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Whether a segment is used: it is a part, or a class of the mapping. `others`: its other names.
using IsUsed =
    std::function<bool(std::int64_t number, const std::string& name, const std::vector<std::string>& others)>;

class SegmentOverlaps {
 public:
  /// `segment`: 1 or more. An empty name stands for the segment's number.
  void add(std::int64_t segment, const std::string& name, bool used);
  bool used(std::int64_t segment) const;

  /// The segment that gets a voxel which `held` has (0: none) and `next` claims. Counts the voxel.
  std::int64_t winner(std::int64_t held, std::int64_t next);

  /// Sentences about all voxels that several segments claimed. Errors: two used segments that overlap by more
  /// than a twentieth of the smaller one, or that have the same name.
  Result<std::vector<std::string>> warnings(const std::string& path) const;

  /// Segments that lost every voxel to others.
  std::vector<std::int64_t> emptied() const;

 private:
  struct Segment {
    std::string name;
    bool used = false;
  };
  struct Meeting {
    std::size_t voxels = 0;
    std::int64_t winner = 0;
  };
  using Pair = std::pair<std::int64_t, std::int64_t>;  // held, next

  std::map<std::int64_t, Segment> segments_;
  std::map<Pair, Meeting> meetings_;
  Pair last_;                   // voxels come in runs:
  Meeting* of_last_ = nullptr;  // looked up once a run
};

}  // namespace borelli
