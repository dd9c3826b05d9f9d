// From slices that look alike to volumes: copies, phases, stations.
#pragma once

#include <string>
#include <vector>

#include "segmentation/dicom_slice.hpp"

namespace borelli {

struct DicomVolume {
  std::vector<DicomSlice> slices;
  std::string part;                ///< which of its series, e.g. "acquisition 2"; empty where it is all of it
  std::vector<std::string> notes;  ///< copies, joined acquisitions, joined series: one sentence each
};

/// Slices of a volume share series, size, orientation and spacing; the last two up to the rounding of their
/// decimals.
bool belong_together(const DicomSlice& a, const DicomSlice& b);

/// Groups of slices that belong together to volumes.
///
/// A copy is what has another's position, scaling and stored pixels, whatever its UIDs; it is dropped. Slices
/// that each have a series of their own are one series if they lie evenly. Different pictures at one place
/// part a series by the first attribute that leaves no place twice (phases, echoes); but acquisitions that
/// overlap by less than half are one body in several stations: they are joined, and where they overlap the
/// larger one counts. Errors: a slice that cannot be read.
Result<std::vector<DicomVolume>> volumes_of(std::vector<std::vector<DicomSlice>> groups);

}  // namespace borelli
