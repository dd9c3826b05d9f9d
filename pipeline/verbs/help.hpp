// The words of --help and of the manual page.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace borelli {

/// The words that an option allows; empty if it has no list of choices.
std::vector<std::string> choices_of(const CLI::Option& option);

/// The name of an option's value: FILE, NUMBER, male|female; empty for a flag without a value.
std::string value_name(const CLI::Option& option);

/// What an option means: its description, then in parentheses its range, its default and the options that it
/// needs or excludes.
std::string meaning_of(const CLI::Option& option);

/// Lays out --help: value names and ranges in words, lines of at most 100 characters.
class HelpLayout : public CLI::Formatter {
 public:
  HelpLayout() { column_width(32); }
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_subcommand(const CLI::App* verb) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

}  // namespace borelli
