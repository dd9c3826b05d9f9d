// Columns of an HDF5 file: fields of structs, one array each.
#pragma once

#include <fmt/core.h>

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "dynamics/system/trajectory.hpp"
#include "error/error.hpp"
#include "pipeline/files/hdf5_file.hpp"

namespace borelli {

inline void write_column(Hdf5Writer& file, const std::string& name, const std::vector<double>& values,
                         const char* units) {
  file.numbers(name, {values.size()}, values.data(), units);
}

/// One field of all rows as an array.
template <class T, class Field>
void write_column(Hdf5Writer& file, const std::string& name, const std::vector<T>& rows, Field T::*field,
                  const char* units = "") {
  if constexpr (std::is_same_v<Field, std::string>) {
    std::vector<std::string> texts;
    for (const T& row : rows) texts.push_back(row.*field);
    file.texts(name, texts);
  } else {
    std::vector<double> values;
    for (const T& row : rows) values.push_back(static_cast<double>(row.*field));
    write_column(file, name, values, units);
  }
}

/// One row per time, also if there are no columns.
inline void write_rows(Hdf5Writer& file, const std::string& name, std::size_t times, const Rows& rows,
                       const char* units) {
  file.numbers(name, {times, static_cast<std::size_t>(rows.cols())}, rows.data(), units);
}

/// Reads arrays one after the other; the first error is kept and ends the reading.
class Hdf5Fill {
 public:
  Hdf5Fill(const Hdf5Reader& file, const std::filesystem::path& path) : file_(file), path_(path.string()) {}

  bool fine() const { return !error_; }
  const Error& error() const { return *error_; }

  std::vector<double> column(const std::string& name) {
    auto array = numbers(name, 1);
    return array.values;
  }
  std::vector<double> column(const std::string& name, std::size_t count) {
    auto values = column(name);
    expect(name, values.size(), count);
    values.resize(count);
    return values;
  }
  Rows rows(const std::string& name, std::size_t count, std::size_t columns) {
    const Hdf5Array array = numbers(name, 2);
    if (fine()) expect(name, array.shape[0], count);
    if (fine()) expect(name, array.shape[1], columns);
    if (!fine()) return {};
    return Eigen::Map<const Rows>(array.values.data(), static_cast<Eigen::Index>(count),
                                  static_cast<Eigen::Index>(columns));
  }
  Rows rows(const std::string& name, std::size_t count) {
    const Hdf5Array array = numbers(name, 2);
    return fine() ? rows(name, count, array.shape[1]) : Rows();
  }
  Hdf5Array numbers(const std::string& name, std::size_t dimensions) {
    if (!fine()) return {};
    auto array = file_.numbers(name);
    if (!array) {
      error_ = array.error();
    } else if (array->shape.size() != dimensions) {
      complain(fmt::format("{} has {} dimensions, expected {}", name, array->shape.size(), dimensions));
    } else {
      return std::move(*array);
    }
    return {};
  }
  std::vector<std::string> texts(const std::string& name) {
    if (!fine()) return {};
    auto texts = file_.texts(name);
    if (!texts) error_ = texts.error();
    return texts.value_or(std::vector<std::string>{});
  }
  std::vector<std::string> texts(const std::string& name, std::size_t count) {
    auto out = texts(name);
    expect(name, out.size(), count);
    out.resize(count);
    return out;
  }
  double attribute(const std::string& object, const std::string& name) {
    if (!fine()) return 0;
    const auto value = file_.number_attribute(object, name);
    if (!value) error_ = value.error();
    return value.value_or(0);
  }
  /// For data that files of older versions lack.
  bool holds(const std::string& name) const { return file_.holds(name); }
  double attribute_if_there(const std::string& object, const std::string& name, double otherwise = 0) const {
    return file_.number_attribute(object, name).value_or(otherwise);
  }
  std::string text_attribute_if_there(const std::string& object, const std::string& name) const {
    return file_.text_attribute(object, name).value_or("");
  }
  std::string text_attribute(const std::string& object, const std::string& name) {
    if (!fine()) return {};
    const auto value = file_.text_attribute(object, name);
    if (!value) error_ = value.error();
    return value.value_or("");
  }
  /// Converts a number of the file to another type; in a damaged file it may not fit.
  template <class T>
  T as(const std::string& name, double value) {
    if constexpr (std::is_same_v<T, bool>) return value != 0;
    if constexpr (std::is_integral_v<T>) {
      const double most = sizeof(T) > sizeof(int) ? 1e15 : 2e9;
      if (std::abs(value) < most) return static_cast<T>(value);
      complain(fmt::format("{} is {}, expected a whole number", name, value));
      return T{};
    } else {
      return value;
    }
  }
  void expect(const std::string& name, std::size_t found, std::size_t expected) {
    if (found != expected) complain(fmt::format("{} has {} entries, expected {}", name, found, expected));
  }
  void complain(std::string what) {
    if (fine()) error_ = Error{path_, std::move(what), Error::Kind::failure};
  }

 private:
  const Hdf5Reader& file_;
  std::string path_;
  std::optional<Error> error_;
};

/// Fills one field of all rows from an array of rows.size() entries.
template <class T, class Field>
void read_column(Hdf5Fill& fill, const std::string& name, std::vector<T>& rows, Field T::*field) {
  if constexpr (std::is_same_v<Field, std::string>) {
    auto texts = fill.texts(name, rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].*field = std::move(texts[i]);
  } else {
    const auto values = fill.column(name, rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].*field = fill.as<Field>(name, values[i]);
  }
}

}  // namespace borelli
