// A volume file's header, and its voxels as stored: common to all formats.
//
// Each format (nifti.cpp, nrrd.cpp, metaimage.cpp) reads and checks its header into ImageHeader; load_voxels
// then loads the voxels of all formats. ITK's readers are not used: they refuse sheared and slightly
// non-orthonormal directions, and a malformed header can abort the process inside MetaIO.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "segmentation/files/byte_stream.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// Called with the fraction done, 0 to 1.
using Progress = std::function<void(double)>;

enum class Scalar { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

std::size_t scalar_bytes(Scalar scalar);
std::string_view scalar_name(Scalar scalar);  ///< e.g. "int16"

/// A segment of a 3D Slicer segmentation: its value in its layer. Also a label named in a NIfTI file.
struct ImageSegment {
  std::string name;
  std::int64_t value = 0;
  std::int64_t layer = 0;
  std::vector<std::string> other_names;  ///< by its coded terminology and ID, likeliest first
};

/// A file of voxels.
struct VoxelFile {
  std::string path;
  std::uint64_t offset = 0;  ///< bytes before the stream starts
};

struct ImageHeader {
  std::string format;  ///< e.g. "NIfTI-1"
  Grid grid;           ///< mm, LPS
  Scalar scalar = Scalar::i16;
  bool big_endian = false;             ///< byte order of the voxels in the file
  double slope = 1, intercept = 0;     ///< value = slope * stored + intercept
  std::string description;             ///< the file's own free text, where it has one
  std::vector<ImageSegment> segments;  ///< of a .seg.nrrd, in its order; NIfTI's named labels
  std::int64_t layers = 1;             ///< volumes in the file, whose segments may overlap
  bool layers_interleaved = false;     ///< a voxel's layers are adjacent; else layer after layer
  std::string recorded_quantity;       ///< hu, density_kgm3, ... if our own writer noted it
  std::vector<std::string> warnings;   ///< doubts about the header

  std::string header_file;  ///< of a NIfTI pair the .hdr; else the file that was given
  std::string data_file;    ///< where the voxels are (the header's own file, or one beside it)
  ByteSource::Packing packing = ByteSource::Packing::plain;
  std::uint64_t file_offset = 0;    ///< bytes of data_file before the stream starts
  std::uint64_t stream_offset = 0;  ///< bytes of the (unpacked) stream before the first voxel
  bool text = false;                ///< the voxels are numbers written as text
  /// Slice files in order, each with an equal share of the slices; data_file is the first. Empty: one file.
  std::vector<VoxelFile> slice_files;

  std::vector<VoxelFile> voxel_files() const {
    return slice_files.empty() ? std::vector{VoxelFile{data_file, file_offset}} : slice_files;
  }
};

/// Voxels as stored, in the machine's byte order; of all layers.
struct StoredVoxels {
  Scalar scalar = Scalar::i16;
  std::size_t count = 0;
  /// The voxels' bytes, count * scalar_bytes(scalar) of them. The element type is int16 so that to_int16 can
  /// convert in place.
  std::vector<std::int16_t> storage;
  std::vector<std::string> warnings = {};  ///< of a file with a slice or more than its header describes

  const std::byte* bytes() const { return reinterpret_cast<const std::byte*>(storage.data()); }
};

/// Errors: damaged or absurd header (with the field and what was expected), more than three dimensions,
/// colours.
Result<ImageHeader> read_nifti_header(const std::string& path);
/// The file of a NIfTI pair that ends in `ending` (.hdr or .img) or `ending`.gz; empty: it does not exist.
/// `path`: either file of the pair.
std::string half_of_nifti_pair(const std::string& path, const std::string& ending);
Result<ImageHeader> read_nrrd_header(const std::string& path);
Result<ImageHeader> read_metaimage_header(const std::string& path);

/// Reads a header; the extension gives the format. Errors: no such file, an unsupported extension, and those
/// of the formats.
Result<ImageHeader> read_image_header(const std::string& path);

/// Called with voxels [first, last) once they are read, by other threads than the one that reads on, several
/// at a time.
using Look = std::function<void(const StoredVoxels& voxels, std::size_t first, std::size_t last)>;

/// Loads the voxels. Errors: file shorter than its header says, damaged compressed data, too large for
/// memory.
Result<StoredVoxels> load_voxels(const ImageHeader& header, const Progress& progress = {},
                                 const Look& look = {});

/// Each writes a volume. `voxels`: i16 or u8 as stored, grid.count() of them. `recorded_quantity`: as in
/// ImageHeader. Errors: not writable, disk full, a grid that the format cannot represent.
Result<void> write_nifti(const std::string& path, const Grid& grid, Scalar scalar,
                         std::span<const std::byte> voxels, const std::string& recorded_quantity);
Result<void> write_nrrd(const std::string& path, const Grid& grid, Scalar scalar,
                        std::span<const std::byte> voxels, const std::string& recorded_quantity);
Result<void> write_metaimage(const std::string& path, const Grid& grid, Scalar scalar,
                             std::span<const std::byte> voxels, const std::string& recorded_quantity);

/// The largest |cosine| between two of the grid's axes: 0 if they are orthogonal.
double shear(const Grid& grid);

/// Calls f(T{}) with T the C++ type of `scalar`.
template <class F>
decltype(auto) with_scalar(Scalar scalar, F&& f) {
  switch (scalar) {
    case Scalar::u8:
      return f(std::uint8_t{});
    case Scalar::i8:
      return f(std::int8_t{});
    case Scalar::u16:
      return f(std::uint16_t{});
    case Scalar::i16:
      return f(std::int16_t{});
    case Scalar::u32:
      return f(std::uint32_t{});
    case Scalar::i32:
      return f(std::int32_t{});
    case Scalar::u64:
      return f(std::uint64_t{});
    case Scalar::i64:
      return f(std::int64_t{});
    case Scalar::f32:
      return f(float{});
    case Scalar::f64:
      return f(double{});
  }
  return f(std::int16_t{});  // not reached
}

}  // namespace borelli
