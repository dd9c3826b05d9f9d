// Settings in TOML, for a program with options of each kind.
#include "pipeline/verbs/settings.hpp"
#include <optional>

#include "pipeline/verbs/value_check.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_settings {

std::vector<TestCase> seeds() {
  return {
      {"each_kind",
       {{"a.toml",
         "threads = 2\njson = true\n\n[run]  # a verb\nvolume = \"a.nii\"\nsex = \"male\"\nwork-grid = 3.5\n"
         "deface = true\nkeep = [\"centre\", \"turn:head\"]\nstep = 1e-3\nstature = 1.8\n"}}},
      {"dotted", {{"a.toml", "run.volume = 'b.nii'\nrun.work-grid = 4\nrun.keep = \"centre\"\n"}}},
      {"one_table", {{"a.toml", "run = {volume = \"\"\"c\n.nii\"\"\", sex = \"female\"}\n"}}}};
}

Result<void> read(const std::filesystem::path& file) {
  CLI::App program{"a program", "borelli"};
  bool json = false, deface = false;
  int threads = 0;
  std::string volume, sex;
  double grid = 3, stature = 0;
  std::optional<double> step;
  std::vector<std::string> keep;
  program.require_subcommand(1);
  program.fallthrough();
  program.add_flag("--json", json);
  program.add_option("--threads", threads)->check(CLI::Range(0, 1024));
  const auto settings = std::make_shared<TomlSettings>(program);
  program.set_config("--settings");
  program.config_formatter(settings);
  program.allow_config_extras(CLI::config_extras_mode::error);
  auto* verb = program.add_subcommand("run");
  verb->allow_config_extras(CLI::config_extras_mode::error);
  verb->add_option("volume", volume)->required();
  verb->add_option("--sex", sex)->check(CLI::IsMember({"male", "female"}));
  verb->add_option("--work-grid", grid)->check(number_within(0.5, 20))->capture_default_str();
  verb->add_option("--stature", stature)->check(positive_number());
  verb->add_option("--step", step)->check(positive_number());
  verb->add_option("--keep", keep)->allow_extra_args(false);
  verb->add_flag("--deface", deface);
  try {
    program.parse({"run", file.string(), "--settings"});  // CLI11 takes words from the end
  } catch (const CLI::ParseError& e) {
    // as program.cpp says it
    const std::string what = e.what(), colon = what.starts_with(':') ? "" : ":";
    if (e.get_name() == "SettingsError") return bad_use("", file.string() + colon + what);
    return bad_use(file.string(), what);
  }
  static_cast<void>(settings_text(*verb));
  return {};
}

}  // namespace of_settings

Reader settings_reader() { return {"settings", of_settings::seeds, of_settings::read}; }

}  // namespace borelli::mutation
