// Builds volumes from the slices of series: drops copies, splits phases, joins stations.
#pragma once

#include <string>
#include <vector>

#include "segmentation/files/dicom_slice.hpp"

namespace borelli {

struct DicomVolume {
  std::vector<DicomSlice> slices;
  std::string part;                ///< part of its series, e.g. "acquisition 2"; empty: all of it
  std::vector<std::string> notes;  ///< copies, joined acquisitions, joined series: one sentence each
};

/// Whether two slices share series, modality, size, orientation and spacing; the last two up to rounding.
bool belong_together(const DicomSlice& a, const DicomSlice& b);

/// Makes volumes of groups of slices that belong together.
///
/// - A slice with the position and values of another is a copy, whatever its UIDs and packing, and dropped.
/// - Three or more series of one slice each are one series; so are those of up to five slices if all their
///   slices together are evenly spaced without gaps.
/// - A series with different images at one place is split by the first attribute that leaves no place twice
///   (acquisition, time, echo, image type).
/// - Acquisitions that overlap by less than half are stations of one body and joined. Where they overlap, the
///   larger one counts.
///
/// Errors: a slice that cannot be read.
Result<std::vector<DicomVolume>> volumes_of(std::vector<std::vector<DicomSlice>> groups);

}  // namespace borelli
