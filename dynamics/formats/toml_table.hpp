// Strict reading of a TOML table: missing or unknown keys and wrong types are refused with file and line.
// Inside the reader a refusal is thrown; the entry point of the file catches it and returns an Error.
#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// Thrown by TomlTable, caught at the entry point of the file.
struct TomlRefusal {
  Error error;
};

/// A table being read. `what` names it in errors ("solid 'thigh'"), `file` the file. Keys that were asked for
/// count as known; finish() refuses all others.
class TomlTable {
 public:
  TomlTable(const toml::table& table, std::string file, std::string what);

  /// The value of a key, or null if it is missing.
  const toml::node* find(std::string_view key);
  const toml::node& require(std::string_view key);
  /// The one of these keys that is present; refuses none and more than one.
  std::string_view one_of(const std::vector<std::string_view>& keys);
  void finish() const;

  /// Readers of one value; `label` names it in errors. Numbers must be finite.
  double number(const toml::node& node, std::string_view label) const;
  bool boolean(const toml::node& node, std::string_view label) const;
  std::string text(const toml::node& node, std::string_view label) const;
  /// A non-empty text.
  std::string name(const toml::node& node, std::string_view label) const;
  /// A list of numbers, of the given length unless that is 0.
  std::vector<double> numbers(const toml::node& node, std::string_view label, std::size_t length = 0) const;
  Eigen::Vector3d vector3(const toml::node& node, std::string_view label) const;
  const toml::array& list(const toml::node& node, std::string_view label) const;
  TomlTable table(const toml::node& node, std::string what) const;
  /// The table or tables under a key: [[key]], an inline table or a list of such. Empty if it is missing.
  std::vector<const toml::node*> tables(std::string_view key);

  /// Readers by key of optional values; a missing key leaves `value` unchanged.
  void read(std::string_view key, double& value);
  void read(std::string_view key, std::string& value);
  void read(std::string_view key, Eigen::Vector3d& value);

  const std::string& what() const { return what_; }
  void rename(std::string what) { what_ = std::move(what); }
  std::string where(const toml::node& node) const;
  const toml::node& node() const { return *table_; }
  /// The line where it begins in its file; 0: unknown.
  int line() const { return static_cast<int>(table_->source().begin.line); }

  /// The description of a value for errors: "the number 3", "a table".
  static std::string kind_of(const toml::node& node);

  [[noreturn]] void refuse(const toml::node& at, const std::string& sentence) const;
  [[noreturn]] void refuse(const std::string& sentence) const { refuse(*table_, sentence); }

 private:
  const toml::table* table_;
  std::string file_, what_;
  std::vector<std::string> known_;
};

}  // namespace borelli
