// HDF5 files as far as this program needs them: named arrays of numbers with units, lists of texts,
// attributes. Thin ownership around HDF5's C interface; damaged files end in a sentence, not in HDF5's own
// error stack, nor in a crash or a hang of HDF5 1.10.
//
// A file of ours ends in the digest of all its bytes before, which HDF5 takes no notice of, and cuts off
// where another program changes the file:
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

struct Hdf5Array {
  std::vector<std::size_t> shape;  ///< row-major
  std::vector<double> values;      ///< product of shape
};

/// Builds a new file in memory; close() writes it (an old one of that name is replaced). Names are paths,
/// "/group/array"; groups arise as needed. The first thing that fails is kept and answered by close(); what
/// follows it is left out.
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
  /// Attributes of a group or array that is there ("/" for the file).
  void attribute(const std::string& object, const std::string& name, const std::string& text);
  void attribute(const std::string& object, const std::string& name, double number);
  void group(const std::string& name);

  /// Writes the file, once; says what failed, if anything did.
  Result<void> close();

 private:
  void check(bool fine, const std::string& what);
  std::string path_, problem_;
  std::int64_t file_ = -1;
};

/// Reads a file. Every answer that is missing or of another type is an error that names the file and the
/// array.
class Hdf5Reader {
 public:
  /// Opens the file for `take`. One whose digest is wrong is refused before HDF5 sees it. One without a
  /// digest is taken twice: first in a child process, with limits of time and memory, and then, if that went
  /// well, in this one, from the same state and so with the same end. What `take` leaves is that of the
  /// second time.
  static Result<void> read(const std::filesystem::path& path,
                           const std::function<Result<void>(const Hdf5Reader&)>& take);

  /// For a file that is known to be whole.
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
  Hdf5Reader(std::string path, std::int64_t file) : path_(std::move(path)), file_(file) {}
  tl::unexpected<Error> damaged(const std::string& name, const std::string& what) const;
  std::string path_;
  std::int64_t file_ = -1;
};

}  // namespace borelli
