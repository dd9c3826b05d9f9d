// Writes a label map as a DICOM segmentation object (DICOM-SEG).
//
// PS3.3, A.51 and C.8.20: a binary segment for each label, one bit per pixel. A frame is a slice of one
// segment; empty ones are left out. Segments are numbered from 1 in the order of labels. Equal input gives
// an equal file: UIDs come from its digest.
#pragma once

#include <string>

#include "error/error.hpp"
#include "segmentation/files/dicom_source.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct DicomLabelOptions {
  /// The scan that the labels belong to: the file joins its study and refers to its images. Null: a study of
  /// its own.
  const DicomSource* source = nullptr;
  /// Copies the patient and the date of the study from the source. Else these elements are empty, and the
  /// date is 1970-01-01.
  bool patient = false;
  std::string version;  ///< of the program, for the module Enhanced General Equipment
};

/// Coordinates have at most 16 characters, which is DICOM's limit. Errors: the labels are on another grid
/// than the source; no voxel has a label; rows and columns are not at right angles; a name has over 64 bytes
/// or a backslash; there are over 65535 rows or columns, or over 4 GiB of bits; those of write_dicom.
Result<void> write_dicom_labels(const std::string& path, const LabelMap& labels,
                                const DicomLabelOptions& options);

}  // namespace borelli
