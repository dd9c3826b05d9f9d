// One file of a DICOM series: what its header says, and its pixels.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
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
  /// File offset of a deflated data set; 0: not deflated.
  std::uint64_t deflated_from = 0;
  std::uint64_t offset = 0, bytes = 0;  ///< in the file or inflated data set, if not packed
  /// File offset and length of each fragment of packed pixels (JPEG, RLE ...).
  std::vector<std::pair<std::uint64_t, std::uint32_t>> fragments;
  std::string packing;  ///< UID of the transfer syntax
};

/// The header fields of a slice that a volume needs (PS3.3, C.7.6.2); none names the patient.
struct DicomSlice {
  std::string path;
  std::string series_uid;
  std::string modality;  ///< "CT", "MR", ...
  std::string series_description;
  std::string patient_sex;       ///< as DICOM codes it: M, F, O (0010,0040)
  std::string patient_age;       ///< as DICOM codes it: 034Y, 018M, 003W, 012D (0010,1010)
  std::string patient_position;  ///< as DICOM codes it: "HFS" is head first, supine (PS3.3, C.7.3.1.1.2)
  std::string rescale_type;      ///< "HU", "US" (unspecified) or empty
  std::string packing;           ///< how the pixels are packed, in words; empty: not packed
  int columns = 0, rows = 0;
  int samples_per_pixel = 1, frames = 1;
  std::optional<Eigen::Vector3d> position;                     ///< centre of the first pixel, mm, LPS
  Eigen::Vector3d position_decimal = Eigen::Vector3d::Zero();  ///< unit of its text's last decimal, mm
  Eigen::Vector3d along_row = Eigen::Vector3d::Zero();         ///< direction of rising column number, unit
  Eigen::Vector3d along_column = Eigen::Vector3d::Zero();      ///< direction of rising row number, unit
  double column_spacing = 0, row_spacing = 0;  ///< between columns (along a row), between rows; mm
  /// SliceThickness and SpacingBetweenSlices, mm; 0: not given.
  double thickness = 0, spacing_between = 0;
  std::optional<double> location;      ///< SliceLocation along the table, mm from any origin
  double reconstruction_diameter = 0;  ///< width of the reconstructed image, mm; 0: not given
  double slope = 1, intercept = 0;
  bool is_scaled = false;         ///< the file gives slope and intercept
  std::optional<double> padding;  ///< stored value of pixels outside the picture
  std::string acquisition, temporal_position, echo,
      image_type;  ///< what may tell volumes of one series apart
  DicomPixels pixels;

  /// Right-handed with the rows and columns; unit.
  Eigen::Vector3d normal() const;
};

/// The header of a DICOM file; empty if the file is not a DICOM image. Errors: a DICOM file that is cut or
/// damaged.
Result<std::optional<DicomSlice>> read_dicom_header(const std::string& path);

/// The slices of a DICOM file: one, or one per frame of an enhanced multi-frame file, positioned by its
/// functional groups (PS3.3, C.7.6.16). None if the file is not a DICOM image. A multi-frame file without
/// functional groups is one slice with `frames` > 1. Errors: as read_dicom_header; frames and functional
/// groups that do not agree; packed frames whose fragments cannot be assigned.
Result<std::vector<DicomSlice>> read_dicom_slices(const std::string& path);

/// Checks before pixels are allocated that a slice's file can hold as many as its header says.
/// Errors: pixels of other than 8, 16 or 32 bits; a file that is cut off or damaged.
Result<void> check_pixels(const DicomSlice& slice);

/// Reads the stored (not rescaled) pixels of slices of one size into `to`: columns * rows per slice, row by
/// row. T (std::int16_t or std::int32_t) takes the low bits of each pixel. RLE is unpacked in this process;
/// JPEG, JPEG-LS and JPEG 2000 in child processes, several slices in each. `done` gets the number of slices
/// read so far. Errors: a file that is cut off or damaged; an unknown packing.
template <class T>
Result<void> read_dicom_pixels(std::span<const DicomSlice> slices, std::span<T> to,
                               const std::function<void(std::size_t)>& done = {});
template <class T>
Result<void> read_dicom_pixels(const DicomSlice& slice, std::span<T> to) {
  return read_dicom_pixels(std::span(&slice, 1), to);
}

/// Reads bytes of slice files. Consecutive frames of a deflated data set are inflated in one pass.
class DicomBytes {
 public:
  /// Fills `to` from `offset` in the slice's file or inflated data set. Errors: it ends too early.
  Result<void> read(const DicomSlice& slice, std::uint64_t offset, std::span<std::byte> to);

  DicomBytes();
  ~DicomBytes();

 private:
  struct Open;
  std::unique_ptr<Open> open_;
};

}  // namespace borelli
