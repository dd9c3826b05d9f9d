#include "pipeline/verbs/help.hpp"

#include <fmt/format.h>

#include <sstream>

namespace borelli {
namespace {

constexpr std::size_t longest_line = 100;
constexpr std::size_t longest_choice = 44;  // characters of a list of choices beside the option's name

// CLI11 states an option's type and its checks as "FLOAT:0 to 1" or "TEXT:{male,female}".
std::string value_type(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':'));
}

std::string value_range(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto colon = type.find(':');
  return colon == std::string::npos || type[colon + 1] == '{' ? "" : type.substr(colon + 1);
}

std::string in_lines(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::string out, word;
  std::size_t column = 0;
  while (words >> word) {
    if (column > 0 && column + 1 + word.size() > width) {
      out += '\n';
      column = 0;
    } else if (column > 0) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

std::string joined_names(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  for (const CLI::Option* option : options) names.push_back(option->get_name());
  std::sort(names.begin(), names.end());
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto from = type.find('{'), to = type.find('}');
  std::vector<std::string> words;
  if (from == std::string::npos || to == std::string::npos || to < from) return words;
  std::string word;
  for (const char c : type.substr(from + 1, to - from - 1) + ",") {
    if (c != ',') {
      word += c;
    } else if (!word.empty()) {
      words.push_back(word);
      word.clear();
    }
  }
  return words;
}

std::string value_name(const CLI::Option& option) {
  const int least = option.get_items_expected_min(), most = option.get_items_expected_max();
  if (most == 0) return "";
  std::string name = value_type(option);
  if (name == "FLOAT") name = "NUMBER";
  if (name == "INT" || name == "UINT") name = "N";
  if (const std::string words = fmt::format("{}", fmt::join(choices_of(option), "|"));
      !words.empty() && words.size() <= longest_choice)
    name = words;
  if (least == most && most > 3) return fmt::format("{} x {}", name, most);
  if (least == most && most > 1) {
    const std::string one = name;
    for (int i = 1; i < most; ++i) name += " " + one;
  } else if (option.get_delimiter() != '\0') {
    name += ",...";
  } else if (most > 1 && option.get_allow_extra_args()) {
    name += " ...";
  }
  return name;
}

std::string meaning_of(const CLI::Option& option) {
  std::string text = option.get_description(), standard = option.get_default_str();
  if (standard.starts_with('[') && standard.ends_with(']'))
    standard = standard.substr(1, standard.size() - 2);
  if (!standard.empty()) standard = "default: " + standard;
  // a description may end with its own "(default: ...)"
  if (const auto own = text.rfind(" (default: "); own != std::string::npos && text.ends_with(')')) {
    standard = text.substr(own + 2, text.size() - own - 3);
    text.resize(own);
  }
  std::vector<std::string> notes;
  if (const std::string range = value_range(option); !range.empty()) notes.push_back(range);
  if (const auto words = choices_of(option); fmt::format("{}", fmt::join(words, "|")).size() > longest_choice)
    notes.push_back(fmt::format("one of {}", fmt::join(words, ", ")));
  if (!standard.empty()) notes.push_back(standard);
  if (option.get_required() && option.nonpositional()) notes.emplace_back("required");
  if (const auto needs = option.get_needs(); !needs.empty()) notes.push_back("needs " + joined_names(needs));
  if (const auto others = option.get_excludes(); !others.empty())
    notes.push_back("not with " + joined_names(others));
  return notes.empty() ? text : fmt::format("{} ({})", text, fmt::join(notes, "; "));
}

std::string HelpLayout::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  std::string out = app->get_description() + "\n" + make_usage(app, std::move(name)) + make_positionals(app);
  for (const std::string& group : app->get_groups()) {
    const auto options = app->get_options([&](const CLI::Option* option) {
      return !group.empty() && option->get_group() == group && option->nonpositional();
    });
    if (!options.empty()) out += make_group(group, false, options);
  }
  out += make_subcommands(app, mode);
  return app->get_footer().empty() ? out : out + "\n" + make_footer(app);
}

std::string HelpLayout::make_subcommand(const CLI::App* verb) const {
  std::ostringstream out;
  CLI::detail::format_help(out, verb->get_name(), in_lines(verb->get_description(), longest_line - 16), 16);
  return out.str();
}

std::string HelpLayout::make_option_opts(const CLI::Option* option) const {
  const std::string value = option->nonpositional() ? value_name(*option) : "";
  return value.empty() ? "" : " " + value;
}

std::string HelpLayout::make_option_desc(const CLI::Option* option) const {
  return in_lines(meaning_of(*option), longest_line - column_width_);
}

}  // namespace borelli
