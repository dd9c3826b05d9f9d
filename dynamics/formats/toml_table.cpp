#include "dynamics/formats/toml_table.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

// (node.value<double>() returns nothing for numbers below 2.2e-308)
double number_of(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  return node.as_floating_point()->get();
}

}  // namespace

std::string TomlTable::kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return fmt::format("a list of {}", node.as_array()->size());
    case toml::node_type::string:
      return fmt::format("the text \"{}\"", node.as_string()->get().substr(0, 40));
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return fmt::format("the number {}", number_of(node));
    case toml::node_type::boolean:
      return *node.value<bool>() ? "true" : "false";
    default:
      return "a date or time";
  }
}

TomlTable::TomlTable(const toml::table& table, std::string file, std::string what)
    : table_(&table), file_(std::move(file)), what_(std::move(what)) {}

std::string TomlTable::where(const toml::node& node) const {
  const auto line = node.source().begin.line;
  return line ? fmt::format("{}:{}", file_, line) : file_;
}

void TomlTable::refuse(const toml::node& at, const std::string& sentence) const {
  throw TomlRefusal{{where(at), what_.empty() ? sentence : what_ + ": " + sentence, Error::Kind::use}};
}

const toml::node* TomlTable::find(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  return table_->get(key);
}

const toml::node& TomlTable::require(std::string_view key) {
  const toml::node* node = find(key);
  if (!node) refuse(fmt::format("{} is missing", key));
  return *node;
}

std::string_view TomlTable::one_of(const std::vector<std::string_view>& keys) {
  std::string_view found;
  for (const std::string_view key : keys) {
    const toml::node* node = find(key);
    if (!node) continue;
    if (!found.empty()) refuse(*node, fmt::format("has {} and {}, expected one of them", found, key));
    found = key;
  }
  if (found.empty()) refuse(fmt::format("expected one of {}", fmt::join(keys, ", ")));
  return found;
}

void TomlTable::finish() const {
  for (const auto& [key, node] : *table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    const auto line = key.source().begin.line;
    throw TomlRefusal{{line ? fmt::format("{}:{}", file_, line) : file_,
                       fmt::format("{}unknown key '{}'; known here: {}", what_.empty() ? "" : what_ + ": ",
                                   key.str(), fmt::join(known_, ", ")),
                       Error::Kind::use}};
  }
}

double TomlTable::number(const toml::node& node, std::string_view label) const {
  if (!node.is_number()) refuse(node, fmt::format("{} is {}, expected a number", label, kind_of(node)));
  const double value = number_of(node);
  if (!std::isfinite(value)) refuse(node, fmt::format("{} is {}, expected a finite number", label, value));
  return value;
}

bool TomlTable::boolean(const toml::node& node, std::string_view label) const {
  if (!node.is_boolean()) refuse(node, fmt::format("{} is {}, expected true or false", label, kind_of(node)));
  return node.as_boolean()->get();
}

std::string TomlTable::text(const toml::node& node, std::string_view label) const {
  if (!node.is_string())
    refuse(node, fmt::format("{} is {}, expected a text in quotes", label, kind_of(node)));
  return node.as_string()->get();
}

std::string TomlTable::name(const toml::node& node, std::string_view label) const {
  std::string value = text(node, label);
  if (value.empty()) refuse(node, fmt::format("{} is empty", label));
  return value;
}

const toml::array& TomlTable::list(const toml::node& node, std::string_view label) const {
  if (!node.is_array())
    refuse(node, fmt::format("{} is {}, expected a list in brackets", label, kind_of(node)));
  return *node.as_array();
}

std::vector<double> TomlTable::numbers(const toml::node& node, std::string_view label,
                                       std::size_t length) const {
  if (length > 0 && !(node.is_array() && node.as_array()->size() == length))
    refuse(node, fmt::format("{} is {}, expected a list of {} numbers", label, kind_of(node), length));
  std::vector<double> out;
  for (const toml::node& entry : list(node, label)) out.push_back(number(entry, label));
  return out;
}

Eigen::Vector3d TomlTable::vector3(const toml::node& node, std::string_view label) const {
  const std::vector<double> values = numbers(node, label, 3);
  return {values[0], values[1], values[2]};
}

TomlTable TomlTable::table(const toml::node& node, std::string what) const {
  if (!node.is_table()) refuse(node, fmt::format("{} is {}, expected a table", what, kind_of(node)));
  return {*node.as_table(), file_, std::move(what)};
}

std::vector<const toml::node*> TomlTable::tables(std::string_view key) {
  std::vector<const toml::node*> out;
  const toml::node* node = find(key);
  if (!node) return out;
  if (node->is_table()) return {node};
  if (!node->is_array())
    refuse(*node, fmt::format("{} is {}, expected a table or a list of tables", key, kind_of(*node)));
  for (const toml::node& entry : *node->as_array()) {
    if (!entry.is_table()) refuse(entry, fmt::format("{} contains {}, expected tables", key, kind_of(entry)));
    out.push_back(&entry);
  }
  return out;
}

void TomlTable::read(std::string_view key, double& value) {
  if (const toml::node* node = find(key)) value = number(*node, key);
}

void TomlTable::read(std::string_view key, std::string& value) {
  if (const toml::node* node = find(key)) value = text(*node, key);
}

void TomlTable::read(std::string_view key, Eigen::Vector3d& value) {
  if (const toml::node* node = find(key)) value = vector3(*node, key);
}

}  // namespace borelli
