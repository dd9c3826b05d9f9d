// Reads from a scan what a DICOM object derived from it must state: UIDs of study, series and images.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// An image, or a frame of one.
struct DicomReference {
  std::string series_uid;
  std::string class_uid, instance_uid;
  int frame = 0;  ///< from 1; 0: the image has one frame
};

struct DicomSource {
  Grid grid;                                      ///< of the scan, as read_volume gives it
  std::string study_uid, frame_of_reference_uid;  ///< empty where the files have none
  /// The images that slice k of the grid comes from: one, or two where the slice was interpolated. Images
  /// without UIDs are left out.
  std::vector<std::vector<DicomReference>> images;
  /// The patient and the date: elements of the modules Patient and General Study (PS3.3, C.7.1.1, C.7.2.1),
  /// and SpecificCharacterSet, as the file has them.
  std::map<std::uint32_t, std::string> patient;
};

/// Reads the headers of the series that read_volume reads in a folder or file. Errors: as read_volume; the
/// scan is no DICOM.
Result<DicomSource> read_dicom_source(const std::string& scan);

/// Whether a text is a UID: digits and dots, at most 64 (PS3.5, 9.1).
bool is_dicom_uid(const std::string& text);

}  // namespace borelli
