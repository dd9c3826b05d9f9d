// What HDF5 does for this program. hdf5_file.hpp is the interface to use.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/hdf5_file.hpp"

namespace borelli {

/// A file is HDF5's number of it; below 0: none. Names are paths, "/group/array"; groups arise as needed.
/// What answers a text answers what is wrong ("is damaged"), "" where nothing is.
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
  /// The bytes of a file that was created, with room for some more.
  std::string (*image)(std::int64_t file, std::string& bytes, std::size_t room);
  bool (*close)(std::int64_t file);

  std::int64_t (*open)(const std::string& path);
  bool (*holds)(std::int64_t file, const std::string& name);
  /// What is `name` has been found by holds(). `size` of the file, bytes; `admit` is asked before so many are
  /// taken.
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
