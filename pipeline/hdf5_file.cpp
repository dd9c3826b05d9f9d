#include "pipeline/hdf5_file.hpp"

#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include "pipeline/stages/digest.hpp"
#include "pipeline/whole_file.hpp"
#include "process/child.hpp"
#include "process/input_file.hpp"
#include "process/memory.hpp"

namespace borelli {
namespace {

// An identifier of HDF5's, closed by its own kind's function.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// HDF5 prints its error stack unless told not to; a library of ours never prints.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

Handle text_type() {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose};
}

Handle with_groups() {
  const hid_t list = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(list, 1);
  return {list, H5Pclose};
}

/// Without the time at which it is made, so that a file's bytes are those of its content.
Handle without_times() {
  const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(list, false);
  return {list, H5Pclose};
}

// Looks for HDF5's signature where the format allows it: at byte 0, 512, 1024, 2048, ...
bool has_signature(const std::filesystem::path& path) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  std::ifstream file(path, std::ios::binary);
  std::string found(signature.size(), '\0');
  for (std::streamoff at = 0; file; at = at == 0 ? 512 : 2 * at)
    if (file.seekg(at).read(found.data(), static_cast<std::streamsize>(found.size())) && found == signature)
      return true;
  return false;
}

constexpr std::string_view before_digest = "\nborelli sha256 ";
constexpr std::size_t seal_size = before_digest.size() + 64 + 1;

// The last bytes of a file that close() writes.
std::string seal(const std::string& digest) { return std::string(before_digest) + digest + '\n'; }

// Whether the file ends in the digest of its other bytes. Errors: a digest that is wrong or cut off.
Result<bool> bears_digest(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg(), rest = size - static_cast<std::streamoff>(seal_size);
  if (!file || rest < 0) return false;
  std::string end(seal_size, '\0');
  file.seekg(rest).read(end.data(), static_cast<std::streamsize>(end.size()));
  if (!file) return false;
  if (const auto at = end.find(before_digest); at != 0 || end.back() != '\n') {
    if (at == std::string::npos) return false;
    return failure(path.string(), "is damaged or cut short: its digest is not at its end");
  }
  const auto digest = digest_of_start(path, static_cast<std::uint64_t>(rest));
  if (!digest) return tl::unexpected(digest.error());
  if (end == seal(*digest)) return true;
  return failure(path.string(), "is damaged: its bytes are not those that were written (SHA-256)");
}

// Limits on reading a file without a digest.
ChildLimits limits_for(const std::filesystem::path& path) {
  std::error_code problem;
  const double size = static_cast<double>(std::filesystem::file_size(path, problem));
  ChildLimits limits;
  limits.processor_seconds = 0.2 + size / 20e6;
  limits.seconds = 5 + size / 5e6;
  limits.bytes = std::min<std::uint64_t>(
      memory_limit(), (std::uint64_t{256} << 20) + static_cast<std::uint64_t>(1000 * size));
  return limits;
}

std::string without_nul(const std::string& text) { return text.substr(0, text.find('\0')); }

}  // namespace

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path) : path_(path.string()) {
  const Quiet quiet;
  // The file grows in memory and goes to the disk at once at the end: an HDF5 file whose disk is full can
  // neither be closed nor given up, and HDF5 1.10 crashes over it when the program ends.
  constexpr std::size_t growth = 16 << 20;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, growth, false);
  file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  check(file_ >= 0, "HDF5 cannot make a file in memory");
}

Hdf5Writer::~Hdf5Writer() {
  const Quiet quiet;
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Writer::check(bool fine, const std::string& what) {
  if (!fine && problem_.empty()) problem_ = what;
}

void Hdf5Writer::numbers(const std::string& name, const std::vector<std::size_t>& shape, const double* values,
                         const std::string& units) {
  if (!problem_.empty()) return;
  {
    const Quiet quiet;
    const std::vector<hsize_t> sizes(shape.begin(), shape.end());
    const Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose);
    const Handle groups = with_groups(), times = without_times();
    const Handle array(H5Dcreate2(file_, name.c_str(), H5T_IEEE_F64LE, space, groups, times, H5P_DEFAULT),
                       H5Dclose);
    std::size_t count = 1;
    for (const std::size_t s : shape) count *= s;
    const bool fine = array && (count == 0 || H5Dwrite(array, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL,
                                                       H5P_DEFAULT, values) >= 0);
    check(fine, "cannot write " + name + "");
  }
  if (!units.empty()) attribute(name, "units", units);
}

void Hdf5Writer::texts(const std::string& name, const std::vector<std::string>& values) {
  if (!problem_.empty()) return;
  const Quiet quiet;
  const hsize_t size = values.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose),
      type = text_type(), groups = with_groups(), times = without_times();
  const Handle array(H5Dcreate2(file_, name.c_str(), type, space, groups, times, H5P_DEFAULT), H5Dclose);
  std::vector<const char*> pointers;
  for (const std::string& v : values) pointers.push_back(v.c_str());
  const bool fine =
      array && (values.empty() || H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0);
  check(fine, "cannot write " + name + "");
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, const std::string& text) {
  if (!problem_.empty()) return;
  const Quiet quiet;
  const std::string kept = without_nul(text);
  const char* pointer = kept.c_str();
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose), type = text_type();
  const Handle attribute(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  check(attribute && H5Awrite(attribute, type, &pointer) >= 0,
        "cannot write the attribute " + name + " of " + object);
}

void Hdf5Writer::attribute(const std::string& object, const std::string& name, double number) {
  if (!problem_.empty()) return;
  const Quiet quiet;
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate_by_name(file_, object.c_str(), name.c_str(), H5T_IEEE_F64LE, space,
                                           H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  check(attribute && H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number) >= 0,
        "cannot write the attribute " + name + " of " + object);
}

void Hdf5Writer::group(const std::string& name) {
  if (!problem_.empty()) return;
  const Quiet quiet;
  const Handle groups = with_groups();
  const Handle group(H5Gcreate2(file_, name.c_str(), groups, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  check(static_cast<bool>(group), "cannot make the group " + name);
}

Result<void> Hdf5Writer::close() {
  std::string image;
  if (file_ >= 0) {
    const Quiet quiet;
    check(H5Fflush(file_, H5F_SCOPE_LOCAL) >= 0, "HDF5 cannot complete the file");
    const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
    check(size > 0, "HDF5 cannot tell the file's size");
    if (problem_.empty()) {
      image.reserve(static_cast<std::size_t>(size) + seal_size);
      image.resize(static_cast<std::size_t>(size));
      check(H5Fget_file_image(file_, image.data(), image.size()) == size,
            "HDF5 cannot give the file's bytes");
    }
    check(H5Fclose(file_) >= 0, "HDF5 cannot close the file");
    file_ = -1;
  }
  if (!problem_.empty()) return failure(path_, problem_);
  image += seal(digest_of_bytes(image));
  return write_bytes(path_, image);
}

Result<void> Hdf5Reader::read(const std::filesystem::path& path,
                              const std::function<Result<void>(const Hdf5Reader&)>& take) {
  const auto attempt = [&]() -> Result<void> {
    const auto file = open(path);
    if (!file) return tl::unexpected(file.error());
    return take(*file);
  };
  std::error_code problem;
  if (std::filesystem::is_regular_file(path, problem) && has_signature(path)) {
    const auto known = bears_digest(path);
    if (!known) return tl::unexpected(known.error());
    if (!*known)
      if (auto fine = in_child(path.string(), "is damaged: reading it as HDF5", limits_for(path), attempt);
          !fine)
        return fine;
  }
  return attempt();
}

Result<Hdf5Reader> Hdf5Reader::open(const std::filesystem::path& path) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  if (!has_signature(path)) return bad_use(path.string(), "is not an HDF5 file");
  const Quiet quiet;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0)
    return failure(path.string(), "is an HDF5 file, but damaged or cut short: it cannot be opened");
  return Hdf5Reader(path.string(), file);
}

Hdf5Reader::~Hdf5Reader() {
  const Quiet quiet;
  if (file_ >= 0) H5Fclose(file_);
}

Hdf5Reader::Hdf5Reader(Hdf5Reader&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

tl::unexpected<Error> Hdf5Reader::damaged(const std::string& name, const std::string& what) const {
  return failure(path_, name + " " + what);
}

bool Hdf5Reader::holds(const std::string& name) const {
  const Quiet quiet;
  if (name == "/") return true;
  for (std::size_t end = name.find('/', 1);;
       end = name.find('/', end + 1)) {  // each group on the way must be there
    if (H5Lexists(file_, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

Result<Hdf5Array> Hdf5Reader::numbers(const std::string& name) const {
  if (!holds(name)) return damaged(name, "is missing");
  const Quiet quiet;
  const Handle array(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!array) return damaged(name, "is not an array, or damaged");
  const Handle type(H5Dget_type(array), H5Tclose), space(H5Dget_space(array), H5Sclose);
  const H5T_class_t kind = type ? H5Tget_class(type) : H5T_NO_CLASS;
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return damaged(name, "does not hold numbers");

  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) return damaged(name, "is damaged: it has no shape");
  std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  // a damaged header can claim any size; a file's numbers fill at least a thousandth of what they unpack to
  std::error_code problem;
  const double limit = 1000. * static_cast<double>(std::filesystem::file_size(path_, problem));
  double claimed = 8;
  for (const hsize_t s : sizes) claimed *= static_cast<double>(s);
  if (claimed > limit) return damaged(name, "claims more numbers than the file can hold");

  if (auto fits = admit_memory(path_, name, claimed); !fits) return tl::unexpected(fits.error());
  Hdf5Array out;
  out.shape.assign(sizes.begin(), sizes.end());
  out.values.resize(static_cast<std::size_t>(claimed / 8));
  if (!out.values.empty() &&
      H5Dread(array, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.values.data()) < 0)
    return damaged(name, "is damaged or cut short");
  return out;
}

Result<std::vector<std::string>> Hdf5Reader::texts(const std::string& name) const {
  if (!holds(name)) return damaged(name, "is missing");
  const Quiet quiet;
  const Handle array(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!array) return damaged(name, "is not an array, or damaged");
  const Handle type(H5Dget_type(array), H5Tclose), space(H5Dget_space(array), H5Sclose), memory = text_type();
  if (!type || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) <= 0)
    return damaged(name, "does not hold texts of free length");
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  std::error_code problem;
  if (count < 0 ||
      static_cast<double>(count) > static_cast<double>(std::filesystem::file_size(path_, problem)))
    return damaged(name, "claims more texts than the file can hold");
  std::vector<char*> pointers(static_cast<std::size_t>(count), nullptr);
  if (count > 0 && H5Dread(array, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0)
    return damaged(name, "is damaged or cut short");
  std::vector<std::string> out;
  for (const char* p : pointers) out.emplace_back(p ? p : "");
  if (count > 0) H5Dvlen_reclaim(memory, space, H5P_DEFAULT, pointers.data());
  return out;
}

Result<std::string> Hdf5Reader::text_attribute(const std::string& object, const std::string& name) const {
  const std::string label = "attribute " + name + " of " + object;
  const Quiet quiet;
  const Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  if (!attribute) return damaged(label, "is missing");
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose),
      memory = text_type();
  if (!type || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) <= 0 ||
      H5Sget_simple_extent_npoints(space) != 1)
    return damaged(label, "is not one text");
  char* pointer = nullptr;
  if (H5Aread(attribute, memory, &pointer) < 0) return damaged(label, "is damaged");
  const std::string out = pointer ? pointer : "";
  H5Dvlen_reclaim(memory, space, H5P_DEFAULT, &pointer);
  return out;
}

Result<double> Hdf5Reader::number_attribute(const std::string& object, const std::string& name) const {
  const std::string label = "attribute " + name + " of " + object;
  const Quiet quiet;
  const Handle attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  if (!attribute) return damaged(label, "is missing");
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  const H5T_class_t kind = type ? H5Tget_class(type) : H5T_NO_CLASS;
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || H5Sget_simple_extent_npoints(space) != 1)
    return damaged(label, "is not one number");
  double out = 0;
  if (H5Aread(attribute, H5T_NATIVE_DOUBLE, &out) < 0) return damaged(label, "is damaged");
  return out;
}

}  // namespace borelli
