// Reads settings from a TOML file: every key is a flag of the same name, with one table per verb ([run],
// [simulate] ...).
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// An error in a settings file: ":LINE: what", to be appended to the file's name.
struct SettingsError : CLI::ParseError {
  SettingsError(unsigned line, const std::string& what);
  explicit SettingsError(const borelli::Error& error);
};

/// Reads settings for CLI11 with toml++. Checks every key and value against the program's verbs and flags
/// before CLI11 sees it, so that errors carry the line (SettingsError): unknown verb or setting, wrong type,
/// value that the flag does not allow. The command line overrides the file.
class TomlSettings : public CLI::ConfigTOML {
 public:
  /// `program` must outlive the settings; its verbs may be added later.
  explicit TomlSettings(CLI::App& program) : program_(program) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

 private:
  CLI::App& program_;
};

/// A verb's settings as given on the command line or by default, in the form that TomlSettings reads; empty
/// settings are left out.
std::string settings_text(const CLI::App& verb);

}  // namespace borelli
