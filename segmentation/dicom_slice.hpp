// One file of a DICOM series: what its header says, and its pixels.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// How pixels are stored (PS3.3, C.7.6.3).
struct DicomPixels {
  int bits_allocated = 16, bits_stored = 16, high_bit = 15;
  bool is_signed = false;
  bool big_endian = false;
  std::uint64_t offset = 0, bytes = 0;  ///< where in the file, where they are not packed
  /// Offset and length of each part where they are packed (JPEG, RLE ...).
  std::vector<std::pair<std::uint64_t, std::uint32_t>> fragments;
  std::string packing;  ///< UID of the transfer syntax
};

/// What a slice's header says, of what a volume needs (PS3.3, C.7.6.2). Nothing that names the patient.
struct DicomSlice {
  std::string path;
  std::string instance_uid, series_uid;
  std::string modality;  ///< "CT", "MR", ...
  std::string series_description;
  std::string patient_position;  ///< as DICOM codes it: "HFS" is head first, supine (PS3.3, C.7.3.1.1.2)
  std::string rescale_type;      ///< "HU", "US" (unspecified) or empty
  std::string packing;           ///< how the pixels are packed, in words; empty where they are not
  int columns = 0, rows = 0;
  int samples_per_pixel = 1, frames = 1;
  std::optional<Eigen::Vector3d> position;                 ///< centre of the first pixel, mm, LPS
  Eigen::Vector3d along_row = Eigen::Vector3d::Zero();     ///< direction of rising column number, unit
  Eigen::Vector3d along_column = Eigen::Vector3d::Zero();  ///< direction of rising row number, unit
  double column_spacing = 0, row_spacing = 0;  ///< between columns (along a row), between rows; mm
  double slope = 1, intercept = 0;
  std::optional<double> padding;  ///< stored value of pixels outside the picture
  std::string acquisition, temporal_position, echo,
      image_type;  ///< what may tell volumes of one series apart
  DicomPixels pixels;

  /// Right-handed with the rows and columns; unit.
  Eigen::Vector3d normal() const;
};

/// The header of a DICOM file; nothing where the file is no DICOM image. Errors: a DICOM file that is cut or
/// damaged.
Result<std::optional<DicomSlice>> read_dicom_header(const std::string& path);

/// The slices of a DICOM file: one, or of an enhanced multi-frame file one per frame, placed by its
/// functional groups (PS3.3, C.7.6.16); none where the file is no DICOM image. A multi-frame file without
/// them is one slice whose `frames` are more than one. Errors: as read_dicom_header; frames and functional
/// groups that do not agree; frames packed so that they cannot be told apart.
Result<std::vector<DicomSlice>> read_dicom_slices(const std::string& path);

/// The stored (not rescaled) pixels, row by row, into `to`: columns * rows of them, of each the bits that go
/// into T (std::int16_t or std::int32_t). Errors: cut, damaged or packed in a way that cannot be unpacked
/// here.
template <class T>
Result<void> read_dicom_pixels(const DicomSlice& slice, std::span<T> to);

}  // namespace borelli
