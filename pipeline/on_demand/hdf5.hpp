// Functions of the library that calls HDF5. Use them through hdf5_file.hpp.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/files/hdf5_file.hpp"

namespace borelli {

/// `file` is HDF5's identifier; a negative one means failure. Names are paths such as "/group/array"; missing
/// groups are created. Functions that return a string return the problem ("is damaged"), or "" on success.
struct Hdf5Functions {
  static constexpr const char* library = "borelli_hdf5";

  std::int64_t (*create)(const std::string& path);  ///< in memory
  bool (*put_numbers)(std::int64_t file, const std::string& name, const std::vector<std::size_t>& shape,
                      const double* values);
  bool (*put_texts)(std::int64_t file, const std::string& name, const std::vector<std::string>& values);
  bool (*put_text_attribute)(std::int64_t file, const std::string& object, const std::string& name,
                             const std::string& text);
  bool (*put_number_attribute)(std::int64_t file, const std::string& object, const std::string& name,
                               double number);
  bool (*put_group)(std::int64_t file, const std::string& name);
  /// Copies the file that create() made to `bytes`, with `room` more bytes reserved.
  std::string (*image)(std::int64_t file, std::string& bytes, std::size_t room);
  bool (*close)(std::int64_t file);

  std::int64_t (*open)(const std::string& path);
  bool (*holds)(std::int64_t file, const std::string& name);
  /// Reads the array `name`; call holds() first. `size`: of the file, bytes. `admit` is asked before memory
  /// is allocated, with the number of bytes.
  std::string (*numbers)(std::int64_t file, const std::string& name, double size,
                         const std::function<bool(double bytes)>& admit, Hdf5Array& out);
  std::string (*texts)(std::int64_t file, const std::string& name, double size,
                       std::vector<std::string>& out);
  std::string (*text_attribute)(std::int64_t file, const std::string& object, const std::string& name,
                                std::string& out);
  std::string (*number_attribute)(std::int64_t file, const std::string& object, const std::string& name,
                                  double& out);
};

}  // namespace borelli
