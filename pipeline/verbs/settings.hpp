// Settings from a TOML file: every key is a flag of the same name, a table per verb ([run], [simulate] ...).
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace borelli {

/// Reads settings for CLI11 with toml++, so that what is wrong is told with its line; what the command line
/// says goes before what the file says.
class TomlSettings : public CLI::ConfigTOML {
 public:
  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

  /// The line of a key ("run.grid-step"), 0 where the file has none such.
  int line_of(const std::string& key) const;

 private:
  mutable std::map<std::string, int> lines_;  // CLI11 hands the formatter out as const
};

}  // namespace borelli
