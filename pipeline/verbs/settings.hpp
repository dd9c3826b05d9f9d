// Settings from a TOML file: every key is a flag of the same name, a table per verb ([run], [simulate] ...).
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// An error in a settings file: ":LINE: what", to be put after the file's name.
struct SettingsError : CLI::ParseError {
  SettingsError(unsigned line, const std::string& what);
  explicit SettingsError(const borelli::Error& error);
};

/// Reads settings for CLI11 with toml++. Every key and value is checked against the program's verbs and their
/// flags before CLI11 takes it, so that what is wrong is told with its line (as SettingsError): no such verb
/// or setting, a value of another type, one that the flag does not allow. What the command line says goes
/// before what the file says.
class TomlSettings : public CLI::ConfigTOML {
 public:
  /// `program` must outlive the settings; its verbs may be added later.
  explicit TomlSettings(CLI::App& program) : program_(program) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

 private:
  CLI::App& program_;
};

/// A verb's settings as chosen on the command line or by default, in the form that TomlSettings reads; what
/// is empty is left out.
std::string settings_text(const CLI::App& verb);

}  // namespace borelli
