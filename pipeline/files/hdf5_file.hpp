// HDF5 files as this program needs them: named arrays of numbers with units, lists of texts, attributes. A
// thin wrapper that owns HDF5's handles. A damaged file gives an error for the user, not HDF5's error stack,
// and neither a crash nor a hang of HDF5 1.10.
//
// Files written here end with the digest of all bytes before it. HDF5 ignores it. Another program that
// changes the file drops it:
//
//   "\nborelli sha256 " 64 hexadecimal digits "\n"
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

struct Hdf5Functions;  // on_demand/hdf5.hpp

struct Hdf5Array {
  std::vector<std::size_t> shape;  ///< row-major
  std::vector<double> values;      ///< product of shape
};

/// Builds a new file in memory; close() writes it and replaces an old one of that name. Names are paths,
/// "/group/array"; groups are created as needed. The first failure is kept and returned by close(); later
/// calls do nothing.
class Hdf5Writer {
 public:
  explicit Hdf5Writer(const std::filesystem::path& path);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// `values` holds the product of `shape`; `units` becomes the attribute of that name ("" for none).
  void numbers(const std::string& name, const std::vector<std::size_t>& shape, const double* values,
               const std::string& units);
  void texts(const std::string& name, const std::vector<std::string>& values);
  /// Adds an attribute to an existing group or array ("/" for the file).
  void attribute(const std::string& object, const std::string& name, const std::string& text);
  void attribute(const std::string& object, const std::string& name, double number);
  void group(const std::string& name);

  /// Writes the file; call it once. Error: the first failure.
  Result<void> close();

 private:
  void check(bool fine, const std::string& what);
  std::string path_, problem_;
  std::int64_t file_ = -1;
  const Hdf5Functions* functions_ = nullptr;
};

/// Reads a file. A missing array or attribute, or one of another type, is an error that names the file and
/// the array.
class Hdf5Reader {
 public:
  /// Opens the file and calls `take`. If the file has no digest, a child process with limits on time and
  /// memory calls `take` first; only if that succeeds does this process call it too, and keep its results.
  /// Errors: those of open() and `take`; a wrong digest (found before HDF5 opens the file); a child that
  /// crashed or reached a limit.
  static Result<void> read(const std::filesystem::path& path,
                           const std::function<Result<void>(const Hdf5Reader&)>& take);

  /// Opens a file that is known to be undamaged. Errors: no such file, not HDF5, damaged.
  static Result<Hdf5Reader> open(const std::filesystem::path& path);
  ~Hdf5Reader();
  Hdf5Reader(Hdf5Reader&& other) noexcept;
  Hdf5Reader& operator=(Hdf5Reader&&) = delete;

  bool holds(const std::string& name) const;
  Result<Hdf5Array> numbers(const std::string& name) const;
  Result<std::vector<std::string>> texts(const std::string& name) const;
  Result<std::string> text_attribute(const std::string& object, const std::string& name) const;
  Result<double> number_attribute(const std::string& object, const std::string& name) const;

 private:
  Hdf5Reader(std::string path, std::int64_t file, const Hdf5Functions& functions)
      : path_(std::move(path)), file_(file), functions_(&functions) {}
  tl::unexpected<Error> damaged(const std::string& name, const std::string& problem) const;
  std::string path_;
  std::int64_t file_ = -1;
  const Hdf5Functions* functions_ = nullptr;
};

}  // namespace borelli
