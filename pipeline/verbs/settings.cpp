#include "pipeline/verbs/settings.hpp"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <iterator>
#include <sstream>

#include "dynamics/formats/toml_text.hpp"

namespace borelli {
namespace {

enum class Kind { flag, number, whole_number, text };

Kind kind_of(const CLI::Option& option) {
  if (option.get_expected_max() == 0) return Kind::flag;
  const std::string type = option.get_type_name();  // the type, then the checks
  if (type.starts_with("FLOAT")) return Kind::number;
  return type.starts_with("INT") || type.starts_with("UINT") ? Kind::whole_number : Kind::text;
}

bool is_of(const toml::node& node, Kind kind) {
  switch (kind) {
    case Kind::flag:
      return node.is_boolean();
    case Kind::number:
      return node.is_number();
    case Kind::whole_number:
      return node.is_integer();
    case Kind::text:
      return node.is_string();
  }
  return false;
}

const char* name_of(Kind kind) {
  switch (kind) {
    case Kind::flag:
      return "true or false";
    case Kind::number:
      return "a number";
    case Kind::whole_number:
      return "a whole number";
    case Kind::text:
      return "a text in quotes";
  }
  return "";
}

std::string shown(const toml::node& node) {
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  return text.str();
}

// a TOML value as the word that the command line would contain
std::string word_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  return shown(node);
}

// The words for one key; each has the option's type and passes its checks.
std::vector<std::string> words_for(CLI::Option& option, const std::string& key, unsigned line,
                                   const toml::node& value) {
  const Kind kind = kind_of(option);
  std::vector<std::string> words;
  const auto take = [&](const toml::node& node) {
    if (!is_of(node, kind))
      throw SettingsError(line, fmt::format("{} is {}, expected {}", key, shown(node), name_of(kind)));
    words.push_back(word_of(node));
    for (int n = 0;; ++n) {
      const CLI::Validator* check = nullptr;
      try {
        check = option.get_validator(n);
      } catch (const CLI::OptionNotFound&) {
        return;  // there are no more
      }
      const std::string wrong = (*check)(std::string(words.back()));
      if (!wrong.empty()) throw SettingsError(line, fmt::format("{}: {}", key, wrong));
    }
  };
  const auto* list = value.as_array();
  if (!list) {
    take(value);
    return words;
  }
  const int least = option.get_items_expected_min(), most = option.get_items_expected_max();
  if (most <= 1) throw SettingsError(line, fmt::format("{} is a list, expected {}", key, name_of(kind)));
  for (const auto& entry : *list) take(entry);
  const int count = static_cast<int>(words.size());
  if (count < least || count > most)
    throw SettingsError(
        line, fmt::format("{} has {} entries, expected {}", key, count,
                          least == most ? fmt::format("{}", least) : fmt::format("{} or more", least)));
  return words;
}

CLI::App& verb_of(CLI::App& program, const std::string& name, unsigned line) {
  for (CLI::App* verb : program.get_subcommands([](const CLI::App*) { return true; }))
    if (verb->check_name(name)) return *verb;
  throw SettingsError(line, fmt::format("unknown verb '{}'; see borelli --help", name));
}

CLI::Option* option_of(CLI::App& app, const std::string& key) {
  CLI::Option* option = app.get_option_no_throw("--" + key);
  if (!option) option = app.get_option_no_throw(key);  // options without dashes, e.g. run's volume
  return option && option->get_configurable() ? option : nullptr;
}

}  // namespace

SettingsError::SettingsError(unsigned line, const std::string& what)
    : CLI::ParseError("SettingsError", fmt::format(":{}: {}", line, what), CLI::ExitCodes::InvalidError) {}

SettingsError::SettingsError(const borelli::Error& error)
    : CLI::ParseError("SettingsError", error.message(), CLI::ExitCodes::InvalidError) {}

std::vector<CLI::ConfigItem> TomlSettings::from_config(std::istream& input) const {
  const auto parsed = parse_toml(std::string{std::istreambuf_iterator<char>(input), {}}, "");
  if (!parsed) throw SettingsError(parsed.error());
  const toml::table& file = *parsed;
  std::vector<CLI::ConfigItem> found;
  const auto add = [&](CLI::App& app, std::vector<std::string> parents, const toml::key& name,
                       const toml::node& value) {
    CLI::ConfigItem item;
    item.parents = std::move(parents);
    item.name = std::string(name.str());
    const unsigned line = name.source().begin.line;
    CLI::Option* option = option_of(app, item.name);
    if (!option) throw SettingsError(line, fmt::format("unknown setting {}", item.fullname()));
    item.inputs = words_for(*option, item.fullname(), line, value);
    found.push_back(std::move(item));
  };
  for (const auto& [name, node] : file) {
    const auto* keys = node.as_table();
    if (!keys) {
      add(program_, {}, name, node);
      continue;
    }
    const std::string verb_name(name.str());
    CLI::App& verb = verb_of(program_, verb_name, name.source().begin.line);
    for (const auto& [key, value] : *keys) add(verb, {verb_name}, key, value);
  }
  return found;
}

std::string settings_text(const CLI::App& verb) {
  std::string text = fmt::format("[{}]\n", verb.get_name());
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->get_configurable()) continue;  // help
    const auto& names = option->get_lnames();
    const std::string name = names.empty() ? option->get_name() : names.front();
    const Kind kind = kind_of(*option);
    if (kind == Kind::flag) {
      if (option->count() > 0 && option->results().back() != "false") text += name + " = true\n";
      continue;
    }
    std::vector<std::string> words = option->results();
    if (option->count() == 0) words = {option->get_default_str()};
    std::vector<std::string> values;
    for (const std::string& word : words) {
      double number = 0;
      if (word.empty()) continue;
      const bool is_number = kind != Kind::text && CLI::detail::lexical_cast(word, number);
      values.push_back(is_number ? fmt::format("{}", number) : shown(toml::value<std::string>(word)));
    }
    if (values.size() == 1) text += fmt::format("{} = {}\n", name, values.front());
    if (values.size() > 1) text += fmt::format("{} = [{}]\n", name, fmt::join(values, ", "));
  }
  return text;
}

}  // namespace borelli
