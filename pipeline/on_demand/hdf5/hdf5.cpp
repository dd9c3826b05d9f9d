// A thin wrapper that owns HDF5's handles.
#include "pipeline/on_demand/hdf5.hpp"

#include <hdf5.h>

#include "process/on_demand.hpp"

namespace borelli {
namespace {

// An HDF5 identifier, closed by the function of its kind.
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

// Silences HDF5's error stack: our libraries never print.
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

/// Dataset properties without the creation time, so that equal contents give equal bytes.
Handle without_times() {
  const hid_t list = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(list, false);
  return {list, H5Pclose};
}

std::string without_nul(const std::string& text) { return text.substr(0, text.find('\0')); }

std::int64_t create(const std::string& path) {
  const Quiet quiet;
  // The file grows in memory and is written to disk at the end. With a full disk an HDF5 file can neither be
  // closed nor abandoned, and HDF5 1.10 crashes when the program ends.
  constexpr std::size_t growth = 16 << 20;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, growth, false);
  return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
}

bool close(std::int64_t file) {
  const Quiet quiet;
  return H5Fclose(file) >= 0;
}

bool put_numbers(std::int64_t file, const std::string& name, const std::vector<std::size_t>& shape,
                 const double* values) {
  const Quiet quiet;
  const std::vector<hsize_t> sizes(shape.begin(), shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose);
  const Handle groups = with_groups(), times = without_times();
  const Handle array(H5Dcreate2(file, name.c_str(), H5T_IEEE_F64LE, space, groups, times, H5P_DEFAULT),
                     H5Dclose);
  std::size_t count = 1;
  for (const std::size_t s : shape) count *= s;
  return array &&
         (count == 0 || H5Dwrite(array, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
}

bool put_texts(std::int64_t file, const std::string& name, const std::vector<std::string>& values) {
  const Quiet quiet;
  const hsize_t size = values.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose),
      type = text_type(), groups = with_groups(), times = without_times();
  const Handle array(H5Dcreate2(file, name.c_str(), type, space, groups, times, H5P_DEFAULT), H5Dclose);
  std::vector<const char*> pointers;
  for (const std::string& v : values) pointers.push_back(v.c_str());
  return array &&
         (values.empty() || H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0);
}

Handle new_attribute(std::int64_t file, const std::string& object, const std::string& name, hid_t type) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  return {H5Acreate_by_name(file, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT,
                            H5P_DEFAULT),
          H5Aclose};
}

bool put_text_attribute(std::int64_t file, const std::string& object, const std::string& name,
                        const std::string& text) {
  const Quiet quiet;
  const std::string kept = without_nul(text);
  const char* pointer = kept.c_str();
  const Handle type = text_type(), attribute = new_attribute(file, object, name, type);
  return attribute && H5Awrite(attribute, type, &pointer) >= 0;
}

bool put_number_attribute(std::int64_t file, const std::string& object, const std::string& name,
                          double number) {
  const Quiet quiet;
  const Handle attribute = new_attribute(file, object, name, H5T_IEEE_F64LE);
  return attribute && H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number) >= 0;
}

bool put_group(std::int64_t file, const std::string& name) {
  const Quiet quiet;
  const Handle groups = with_groups();
  const Handle group(H5Gcreate2(file, name.c_str(), groups, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  return static_cast<bool>(group);
}

std::string image(std::int64_t file, std::string& bytes, std::size_t room) {
  const Quiet quiet;
  if (H5Fflush(file, H5F_SCOPE_LOCAL) < 0) return "HDF5 cannot complete the file";
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  if (size <= 0) return "HDF5 cannot determine the file's size";
  bytes.reserve(static_cast<std::size_t>(size) + room);
  bytes.resize(static_cast<std::size_t>(size));
  return H5Fget_file_image(file, bytes.data(), bytes.size()) == size ? ""
                                                                     : "HDF5 cannot return the file's bytes";
}

std::int64_t open(const std::string& path) {
  const Quiet quiet;
  return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

bool holds(std::int64_t file, const std::string& name) {
  const Quiet quiet;
  if (name == "/") return true;
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {  // each parent group must exist
    if (H5Lexists(file, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

std::string numbers(std::int64_t file, const std::string& name, double size,
                    const std::function<bool(double bytes)>& admit, Hdf5Array& out) {
  const Quiet quiet;
  const Handle array(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!array) return "is not an array, or damaged";
  const Handle type(H5Dget_type(array), H5Tclose), space(H5Dget_space(array), H5Sclose);
  const H5T_class_t kind = type ? H5Tget_class(type) : H5T_NO_CLASS;
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return "does not contain numbers";

  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) return "is damaged: it has no shape";
  std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  // a damaged header can claim any size; compressed numbers need at least a thousandth of their unpacked size
  double claimed = 8;
  for (const hsize_t s : sizes) claimed *= static_cast<double>(s);
  if (claimed > 1000 * size) return "claims more numbers than the file can contain";

  if (!admit(claimed)) return "does not fit into memory";
  out.shape.assign(sizes.begin(), sizes.end());
  out.values.resize(static_cast<std::size_t>(claimed / 8));
  const bool fine = out.values.empty() ||
                    H5Dread(array, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.values.data()) >= 0;
  return fine ? "" : "is damaged or cut short";
}

std::string texts(std::int64_t file, const std::string& name, double size, std::vector<std::string>& out) {
  const Quiet quiet;
  const Handle array(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!array) return "is not an array, or damaged";
  const Handle type(H5Dget_type(array), H5Tclose), space(H5Dget_space(array), H5Sclose), memory = text_type();
  if (!type || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) <= 0)
    return "does not contain texts of variable length";
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count < 0 || static_cast<double>(count) > size) return "claims more texts than the file can contain";
  std::vector<char*> pointers(static_cast<std::size_t>(count), nullptr);
  if (count > 0 && H5Dread(array, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0)
    return "is damaged or cut short";
  for (const char* p : pointers) out.emplace_back(p ? p : "");
  if (count > 0) H5Dvlen_reclaim(memory, space, H5P_DEFAULT, pointers.data());
  return "";
}

std::string text_attribute(std::int64_t file, const std::string& object, const std::string& name,
                           std::string& out) {
  const Quiet quiet;
  const Handle attribute(H5Aopen_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  if (!attribute) return "is missing";
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose),
      memory = text_type();
  if (!type || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) <= 0 ||
      H5Sget_simple_extent_npoints(space) != 1)
    return "is not a single text";
  char* pointer = nullptr;
  if (H5Aread(attribute, memory, &pointer) < 0) return "is damaged";
  out = pointer ? pointer : "";
  H5Dvlen_reclaim(memory, space, H5P_DEFAULT, &pointer);
  return "";
}

std::string number_attribute(std::int64_t file, const std::string& object, const std::string& name,
                             double& out) {
  const Quiet quiet;
  const Handle attribute(H5Aopen_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  if (!attribute) return "is missing";
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  const H5T_class_t kind = type ? H5Tget_class(type) : H5T_NO_CLASS;
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) || H5Sget_simple_extent_npoints(space) != 1)
    return "is not a single number";
  return H5Aread(attribute, H5T_NATIVE_DOUBLE, &out) >= 0 ? "" : "is damaged";
}

}  // namespace
}  // namespace borelli

BORELLI_ON_DEMAND(borelli::Hdf5Functions){.create = borelli::create,
                                          .put_numbers = borelli::put_numbers,
                                          .put_texts = borelli::put_texts,
                                          .put_text_attribute = borelli::put_text_attribute,
                                          .put_number_attribute = borelli::put_number_attribute,
                                          .put_group = borelli::put_group,
                                          .image = borelli::image,
                                          .close = borelli::close,
                                          .open = borelli::open,
                                          .holds = borelli::holds,
                                          .numbers = borelli::numbers,
                                          .texts = borelli::texts,
                                          .text_attribute = borelli::text_attribute,
                                          .number_attribute = borelli::number_attribute};
