// NIfTI-1 and NIfTI-2, one file (.nii, .nii.gz) or a pair (.hdr and .img, packed or not).
//
// Cox et al., "A (sort of) new image data format standard: NIfTI-1", NeuroImage 22 (2004) e1440; field
// offsets and codes from the format's public-domain header nifti1.h (nifti2.h for NIfTI-2). NIfTI uses RAS (x
// to the Right, y to Anterior, z to Superior), we use LPS: only this file changes the signs of x and y.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <optional>

#include "segmentation/files/header_text.hpp"
#include "segmentation/files/image_file.hpp"
#include "segmentation/files/nifti_names.hpp"
#include "segmentation/files/voxel_size.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d ras_to_lps(-1, -1, 1);

// The header's bytes; fields are taken from their offsets, in the file's byte order.
struct Fields {
  std::array<std::byte, 540> bytes{};
  bool swap = false;

  template <class T>
  T get(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (swap) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  std::string text(std::size_t offset, std::size_t length) const {
    const char* const first = reinterpret_cast<const char*>(bytes.data()) + offset;
    return {first, std::find(first, first + length, '\0')};
  }
};

// The fields that matter, from either version of the header.
struct Nifti {
  int version = 1;
  std::array<std::int64_t, 8> dim{};
  int datatype = 0;
  std::array<double, 8> pixdim{};
  double vox_offset = 0, slope = 0, intercept = 0;
  int xyzt_units = 0, qform_code = 0, sform_code = 0;
  std::array<double, 3> quatern{}, qoffset{};
  std::array<std::array<double, 4>, 3> srow{};
  std::string description;
  bool big_endian = false;
  bool pair = false;  // the voxels are in a second file
};

template <class Integer, class Real, class Code>
void take(const Fields& f, Nifti& n, std::size_t dim, std::size_t datatype, std::size_t pixdim,
          std::size_t slope, std::size_t units, std::size_t qform, std::size_t sform, std::size_t quatern,
          std::size_t srow) {
  for (std::size_t i = 0; i < 8; ++i) n.dim[i] = f.get<Integer>(dim + i * sizeof(Integer));
  n.datatype = f.get<std::int16_t>(datatype);
  for (std::size_t i = 0; i < 8; ++i) n.pixdim[i] = f.get<Real>(pixdim + i * sizeof(Real));
  n.slope = f.get<Real>(slope), n.intercept = f.get<Real>(slope + sizeof(Real));
  n.xyzt_units = static_cast<int>(f.get<Code>(units));
  n.qform_code = static_cast<int>(f.get<Code>(qform)), n.sform_code = static_cast<int>(f.get<Code>(sform));
  for (std::size_t i = 0; i < 3; ++i) n.quatern[i] = f.get<Real>(quatern + i * sizeof(Real));
  for (std::size_t i = 0; i < 3; ++i) n.qoffset[i] = f.get<Real>(quatern + (3 + i) * sizeof(Real));
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) n.srow[r][c] = f.get<Real>(srow + (4 * r + c) * sizeof(Real));
}

Result<Nifti> parse_nifti(const std::string& path) {
  const auto packed = is_gzip(path);
  if (!packed) return tl::unexpected(packed.error());
  auto source = ByteSource::open(path, *packed ? ByteSource::Packing::deflated : ByteSource::Packing::plain);
  if (!source) return tl::unexpected(source.error());
  Fields f;
  const auto got = source->read(f.bytes);
  if (!got) return tl::unexpected(got.error());
  if (*got < 348) return failure(path, "is not a NIfTI file: it is shorter than the header's 348 bytes");

  Nifti n;
  const auto is_header = [&](std::int32_t size) {
    for (const bool swap : {false, true}) {
      f.swap = swap;
      if (f.get<std::int32_t>(0) == size) return true;
    }
    return false;
  };
  if (is_header(348)) {
    n.pair = f.text(344, 4) == "ni1";
    if (!n.pair && f.text(344, 4) != "n+1")
      return failure(path, "is not a NIfTI file (an Analyze file has no orientation)");
    take<std::int16_t, float, std::int16_t>(f, n, 40, 70, 76, 112, 123, 252, 254, 256, 280);
    n.xyzt_units = f.get<std::uint8_t>(123);  // the only code of one byte
    n.vox_offset = f.get<float>(108);
    n.description = f.text(148, 80);
  } else if (*got == 540 && is_header(540) && (f.text(4, 3) == "n+2" || f.text(4, 3) == "ni2")) {
    n.version = 2;
    n.pair = f.text(4, 3) == "ni2";
    take<std::int64_t, double, std::int32_t>(f, n, 16, 12, 104, 176, 500, 344, 348, 352, 400);
    n.vox_offset = static_cast<double>(f.get<std::int64_t>(168));
    n.description = f.text(240, 80);
  } else {
    return failure(path, "is not a NIfTI file: its first number is not a header size (348 or 540)");
  }
  n.big_endian = f.swap != (std::endian::native == std::endian::big);
  return n;
}

std::optional<Scalar> scalar_of(int datatype) {
  switch (datatype) {
    case 2:
      return Scalar::u8;
    case 256:
      return Scalar::i8;
    case 512:
      return Scalar::u16;
    case 4:
      return Scalar::i16;
    case 768:
      return Scalar::u32;
    case 8:
      return Scalar::i32;
    case 1280:
      return Scalar::u64;
    case 1024:
      return Scalar::i64;
    case 16:
      return Scalar::f32;
    case 64:
      return Scalar::f64;
    default:
      return std::nullopt;
  }
}

Result<Scalar> voxel_type(const std::string& path, const Nifti& n) {
  if (const auto scalar = scalar_of(n.datatype)) return *scalar;
  if (n.datatype == 128 || n.datatype == 2304)
    return failure(path, "contains colours (RGB); one grey value per voxel is needed");
  if (n.datatype == 32 || n.datatype == 1792 || n.datatype == 2048)
    return failure(path, "contains complex numbers; one real value per voxel is needed");
  return failure(path,
                 "has voxels of an unsupported type (NIfTI datatype " + std::to_string(n.datatype) + ")");
}

Result<void> check_dimensions(const std::string& path, const Nifti& n) {
  if (n.dim[0] < 1 || n.dim[0] > 7)
    return failure(path, "has a damaged header: " + std::to_string(n.dim[0]) + " dimensions");
  if (n.dim[0] < 3)
    return failure(path,
                   "contains a picture of " + std::to_string(n.dim[0]) + " dimensions; a volume is needed");
  for (std::size_t i = 1; i <= 3; ++i)
    if (n.dim[i] < 1 || n.dim[i] > 100000)
      return failure(path, "has a damaged header: " + std::to_string(n.dim[i]) + " voxels along axis " +
                               std::to_string(i));
  for (std::size_t i = 4; i <= static_cast<std::size_t>(n.dim[0]); ++i)
    if (n.dim[i] > 1)
      return failure(path, "contains " + std::to_string(n.dim[i]) + " volumes along dimension " +
                               std::to_string(i) + "; give a file with one three-dimensional volume");
  return {};
}

// Millimetres per unit of the file. Programs that mean millimetres and write metres are common: if the unit
// gives voxels that no scan of a body has, and millimetres would not, the unit is ignored, with a warning.
Result<double> millimetres(const std::string& path, const Nifti& n, const Vector3d& spacing,
                           std::vector<std::string>& warnings) {
  const auto likely = [&](double unit) {
    return unit * spacing.minCoeff() >= 0.01 && unit * spacing.maxCoeff() <= 50;
  };
  const auto size = [&](double unit) {
    return fmt::format("{:.4g} x {:.4g} x {:.4g} mm", unit * spacing[0], unit * spacing[1],
                       unit * spacing[2]);
  };
  const int code = n.xyzt_units & 7;
  if (code > 3)
    return failure(path, "has lengths in a unit unknown to NIfTI (" + std::to_string(code) +
                             " in xyzt_units); expected 1 (m), 2 (mm) or 3 (micrometres)");
  const double unit = code == 1 ? 1000 : code == 3 ? 0.001 : 1;
  if (code == 0 && likely(1)) return 1;
  if (code == 0 && likely(1000))
    return failure(path, "does not state its unit of length; its voxels would measure " + size(1) +
                             " or, in metres, " + size(1000) + "; set xyzt_units to 2 (mm) or 1 (m)");
  if (code != 2 && code != 0 && !likely(unit) && likely(1)) {
    warnings.push_back(std::string("the header states ") + (code == 1 ? "metres" : "micrometres") +
                       ", so a voxel would measure " + size(unit) + "; its lengths were read as millimetres");
    return 1;
  }
  return unit;
}

struct Placing {
  Matrix3d axes;  // RAS, file's unit
  Vector3d origin;
};

bool usable(const Placing& placing) {
  if (!placing.axes.allFinite() || !placing.origin.allFinite()) return false;
  // the axes must span a voxel: at least a thousandth of the volume of the box of their lengths
  const double box = placing.axes.colwise().norm().prod();
  return box > 0 && std::abs(placing.axes.determinant()) > 1e-3 * box;
}

std::optional<Placing> sform(const Nifti& n) {
  if (n.sform_code <= 0) return std::nullopt;
  Placing placing;
  for (int r = 0; r < 3; ++r) {
    const auto& row = n.srow[static_cast<std::size_t>(r)];
    placing.axes.row(r) << row[0], row[1], row[2];
    placing.origin[r] = row[3];
  }
  return placing;
}

// nifti1.h, "method 2": quaternion, pixdim as scales, pixdim[0] as the sign of the third axis
std::optional<Placing> qform(const Nifti& n) {
  if (n.qform_code <= 0) return std::nullopt;
  const Vector3d v(n.quatern[0], n.quatern[1], n.quatern[2]);
  Eigen::Quaterniond q(std::sqrt(std::max(0.0, 1 - v.squaredNorm())), v.x(), v.y(), v.z());
  q.normalize();
  const Vector3d scale(std::abs(n.pixdim[1]), std::abs(n.pixdim[2]),
                       std::abs(n.pixdim[3]) * (n.pixdim[0] < 0 ? -1 : 1));
  return Placing{q.toRotationMatrix() * scale.asDiagonal(),
                 Vector3d(n.qoffset[0], n.qoffset[1], n.qoffset[2])};
}

// nifti1.h, "method 1": neither form is set
Placing without_form(const Nifti& n) {
  return {Vector3d(n.pixdim[1], n.pixdim[2], n.pixdim[3]).cwiseAbs().asDiagonal(), Vector3d::Zero()};
}

// the largest distance between a grid corner by two placings, in voxels of the first
double disagreement(const Placing& a, const Placing& b, const Nifti& n) {
  double worst = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Vector3d index;
    for (int c = 0; c < 3; ++c)
      index[c] = corner >> c & 1 ? static_cast<double>(n.dim[static_cast<std::size_t>(c) + 1] - 1) : 0;
    const Vector3d apart = (a.axes - b.axes) * index + a.origin - b.origin;
    worst = std::max(worst, apart.norm() / a.axes.colwise().norm().minCoeff());
  }
  return worst;
}

Result<Placing> placing_of(const std::string& path, const Nifti& n, std::vector<std::string>& warnings) {
  auto s = sform(n), q = qform(n);
  if (s && !usable(*s)) {
    warnings.push_back("the sform does not map the three axes and was ignored");
    s.reset();
  }
  if (q && !usable(*q)) {
    warnings.push_back("the qform is not a valid placement and was ignored");
    q.reset();
  }
  if (s) {
    std::vector<SizeField> fields{{"sform", s->axes.colwise().norm()}};
    const Vector3d pixdim = Vector3d(n.pixdim[1], n.pixdim[2], n.pixdim[3]).cwiseAbs();
    if (q) fields.push_back({"qform", pixdim});  // its lengths are pixdim
    // with a tilted gantry, pixdim may be the slice distance along the normal
    const bool tilted = shear({.axes = s->axes}) > 1e-3;
    fields.push_back({"pixdim", pixdim, tilted && !q});
    const auto size = voxel_size(path, fields, warnings);
    if (!size) return tl::unexpected(size.error());
    resize_axes(s->axes, *size);
  }
  if (s && q) {
    // both are stored as float32; half a voxel apart is more than rounding
    const double apart = disagreement(*s, *q, n);
    if ((s->axes.determinant() > 0) != (q->axes.determinant() > 0))
      return failure(path,
                     "has an sform and a qform that mirror each other, so left and right are unknown; set "
                     "the code of the wrong one to 0 (sform_code or qform_code), or convert the scan again");
    if (apart > 0.5)
      warnings.push_back(
          fmt::format("the sform and the qform differ by up to {:.1f} voxels; the sform was used", apart));
  }
  if (s) return *s;
  if (q) return *q;
  const Placing plain = without_form(n);
  if (!usable(plain))
    return failure(path, "has a damaged header: it has no sform, no qform, and a voxel size of 0");
  warnings.push_back(
      "the file does not state the patient's orientation; its axes were read as Right, Anterior, Superior");
  return plain;
}

}  // namespace

Result<ImageHeader> read_nifti_header(const std::string& path) {
  const auto n = parse_nifti(path);
  if (!n) return tl::unexpected(n.error());
  if (const auto fine = check_dimensions(path, *n); !fine) return tl::unexpected(fine.error());
  const auto scalar = voxel_type(path, *n);
  if (!scalar) return tl::unexpected(scalar.error());

  ImageHeader header;
  header.format = "NIfTI-" + std::to_string(n->version);
  header.scalar = *scalar;
  header.big_endian = n->big_endian;
  header.description = n->description;
  if (n->description.starts_with("borelli ")) header.recorded_quantity = n->description.substr(8);

  const auto placing = placing_of(path, *n, header.warnings);
  if (!placing) return tl::unexpected(placing.error());
  for (std::size_t c = 0; c < 3; ++c) header.grid.size[c] = n->dim[c + 1];
  const auto unit = millimetres(path, *n, placing->axes.colwise().norm(), header.warnings);
  if (!unit) return tl::unexpected(unit.error());
  header.grid.axes = *unit * ras_to_lps.asDiagonal() * placing->axes;
  header.grid.origin = *unit * ras_to_lps.cwiseProduct(placing->origin);

  if (n->slope != 0 && !std::isnan(n->slope)) {  // else: no scaling
    if (!std::isfinite(n->slope) || !std::isfinite(n->intercept))
      return failure(path, "has a damaged header: scl_slope or scl_inter is not a finite number");
    header.slope = n->slope, header.intercept = n->intercept;
  }

  const double least = n->pair ? 0 : n->version == 1 ? 352 : 544;
  if (!(n->vox_offset <= 1e9)) return failure(path, "has a damaged header: vox_offset is impossible");
  header.stream_offset = static_cast<std::uint64_t>(std::max(least, n->vox_offset));
  header.header_file = header.data_file = path;
  const auto packing_of = [](const std::string& file) -> Result<ByteSource::Packing> {
    return is_gzip(file).map(
        [](bool gzip) { return gzip ? ByteSource::Packing::deflated : ByteSource::Packing::plain; });
  };
  auto packing = packing_of(path);
  if (!packing) return tl::unexpected(packing.error());
  header.packing = *packing;
  ImageHeader extended = header;  // in a pair, extensions follow the header in the .hdr
  const std::uint64_t header_bytes = n->version == 1 ? 348 : 540;
  if (n->pair) extended.stream_offset = header_bytes + (1 << 24);
  auto named = nifti_label_names(extended, header_bytes);
  if (!named) return tl::unexpected(named.error());
  header.segments = std::move(*named);
  if (!n->pair) return header;
  header.data_file = half_of_nifti_pair(path, ".img");
  if (header.data_file.empty())
    return bad_use(path, "is half of a NIfTI pair; put the file with its voxels (.img or .img.gz) beside it");
  packing = packing_of(header.data_file);
  if (!packing) return tl::unexpected(packing.error());
  header.packing = *packing;
  return header;
}

std::string half_of_nifti_pair(const std::string& path, const std::string& ending) {
  std::filesystem::path stem(path);
  if (lower_case(stem.extension().string()) == ".gz") stem.replace_extension();
  std::string capitals = ending;
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::error_code ignored;
  for (const std::string& other : {ending, ending + ".gz", capitals, capitals + ".GZ"})
    if (auto file = stem; std::filesystem::exists(file.replace_extension(other), ignored))
      return file.string();
  return "";
}

namespace {

struct Writer {
  std::array<std::byte, 352> bytes{};  // header and the four bytes that say "no extension"

  template <class T>
  void put(std::size_t offset, T value) {
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(bytes.data() + offset, &value, sizeof value);
  }
};

// Writes the qform of a grid with orthogonal axes. The sform is equal; readers prefer either.
void put_qform(Writer& header, const Matrix3d& axes) {
  Matrix3d rotation = axes.colwise().normalized();
  const bool mirrored = rotation.determinant() < 0;
  if (mirrored) rotation.col(2) *= -1;
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() *= -1;  // the header omits w, which is taken as positive
  header.put<float>(76, mirrored ? -1.f : 1.f);
  header.put<std::int16_t>(252, 1);
  header.put<float>(256, static_cast<float>(q.x()));
  header.put<float>(260, static_cast<float>(q.y()));
  header.put<float>(264, static_cast<float>(q.z()));
}

Writer header_of(const Grid& grid, Scalar scalar, const std::string& recorded_quantity) {
  Writer header;
  header.put<std::int32_t>(0, 348);
  header.put<char>(38, 'r');
  header.put<std::int16_t>(40, 3);
  for (std::size_t c = 0; c < 7; ++c)
    header.put(42 + 2 * c, c < 3 ? static_cast<std::int16_t>(grid.size[c]) : std::int16_t{1});
  header.put<std::int16_t>(70, scalar == Scalar::u8 ? 2 : 4);
  header.put<std::int16_t>(72, scalar == Scalar::u8 ? 8 : 16);
  header.put<float>(76, 1.f);
  const Vector3d spacing = grid.spacing();
  for (int c = 0; c < 3; ++c)
    header.put(80 + 4 * static_cast<std::size_t>(c), static_cast<float>(spacing[c]));
  header.put<float>(108, 352.f);
  header.put<float>(112, 1.f);                                            // slope
  header.put<char>(123, 2);                                               // mm
  if (recorded_quantity == "labels") header.put<std::int16_t>(68, 1002);  // NIFTI_INTENT_LABEL
  const std::string description = "borelli " + recorded_quantity;
  std::memcpy(header.bytes.data() + 148, description.data(), std::min<std::size_t>(description.size(), 79));

  const Matrix3d axes = ras_to_lps.asDiagonal() * grid.axes;  // its own inverse: LPS to RAS
  const Vector3d origin = ras_to_lps.cwiseProduct(grid.origin);
  // float32 keeps seven digits: for axes this close to orthogonal, qform and sform agree
  if (shear(grid) < 1e-6) put_qform(header, axes);
  for (int r = 0; r < 3; ++r) {
    const auto row = 280 + 16 * static_cast<std::size_t>(r);
    for (int c = 0; c < 3; ++c)
      header.put(row + 4 * static_cast<std::size_t>(c), static_cast<float>(axes(r, c)));
    header.put(row + 12, static_cast<float>(origin[r]));
    header.put(268 + 4 * static_cast<std::size_t>(r), static_cast<float>(origin[r]));
  }
  header.put<std::int16_t>(254, 1);
  std::memcpy(header.bytes.data() + 344, "n+1", 4);
  return header;
}

}  // namespace

Result<void> write_nifti(const std::string& path, const Grid& grid, Scalar scalar,
                         std::span<const std::byte> voxels, const std::string& recorded_quantity) {
  for (const auto size : grid.size)
    if (size > 32767)
      return failure(path, "NIfTI-1 allows at most 32767 voxels along an axis; write .nrrd instead");
  auto sink = ByteSink::create(
      path, lower_case(path).ends_with(".gz") ? ByteSink::Packing::gzip : ByteSink::Packing::plain);
  if (!sink) return tl::unexpected(sink.error());
  const Writer header = header_of(grid, scalar, recorded_quantity);
  if (const auto done = sink->write(header.bytes); !done) return done;
  if (const auto done = sink->write(voxels); !done) return done;
  return sink->close();
}

}  // namespace borelli
