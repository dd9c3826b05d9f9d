#include "pipeline/verbs/settings.hpp"

#include <fmt/core.h>

#include <toml++/toml.h>
#include <limits>
#include <sstream>

namespace borelli {
namespace {

struct SettingsError : CLI::ParseError {
  explicit SettingsError(const std::string& what)
      : CLI::ParseError("SettingsError", what, CLI::ExitCodes::InvalidError) {}
};

// a TOML value as the word that the command line would have
std::string word_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  return text.str();
}

}  // namespace

std::vector<CLI::ConfigItem> TomlSettings::from_config(std::istream& input) const {
  toml::table file;
  try {
    file = toml::parse(input);
  } catch (const toml::parse_error& e) {
    throw SettingsError(fmt::format("line {}: {}", e.source().begin.line, e.description()));
  }
  std::vector<CLI::ConfigItem> found;
  lines_.clear();
  const auto add = [&](std::vector<std::string> parents, const toml::key& name, const toml::node& node) {
    CLI::ConfigItem item;
    item.parents = std::move(parents);
    item.name = std::string(name.str());
    if (const auto* list = node.as_array())
      for (const auto& entry : *list) item.inputs.push_back(word_of(entry));
    else
      item.inputs.push_back(word_of(node));
    lines_[item.fullname()] = static_cast<int>(name.source().begin.line);
    found.push_back(std::move(item));
  };
  for (const auto& [name, node] : file) {
    const auto* verb = node.as_table();
    if (!verb) {
      add({}, name, node);
      continue;
    }
    for (const auto& [key, value] : *verb) {
      if (value.is_table())
        throw SettingsError(fmt::format("line {}: [{}.{}] is a table, expected a value",
                                        key.source().begin.line, name.str(), key.str()));
      add({std::string(name.str())}, key, value);
    }
  }
  return found;
}

int TomlSettings::line_of(const std::string& key) const {
  const auto it = lines_.find(key);
  return it == lines_.end() ? 0 : it->second;
}

}  // namespace borelli
