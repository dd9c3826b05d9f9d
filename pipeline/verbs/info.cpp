// borelli info FILE: describes a volume, scene or trajectory.
#include <fmt/core.h>

#include <filesystem>

#include "error/file_ending.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/motion_info.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/verb.hpp"
#include "pipeline/verbs/volume_info.hpp"

namespace borelli {

namespace {

Result<nlohmann::json> volume(const std::string& path, const std::string& quantity, const Command& command) {
  ProgressBar bar(command.json);
  bar.begin("read");
  auto info = volume_info(command, path, quantity, [&](double share) { bar.update(share); });
  if (!info) return info;
  bar.end("done");
  if (!command.json) fmt::print("{}", volume_info_text(*info));
  return info;
}

// A given option of add_model_options; empty if there is none.
std::string model_option(const ModelOptions& options) {
  return options.floating                                      ? "--floating"
         : !options.locked.empty()                             ? "--lock"
         : options.minimum_mass != ModelOptions{}.minimum_mass ? "--minimum-mass"
                                                               : "";
}

// Prints an answer as text.
Result<nlohmann::json> said(Result<nlohmann::json> info, std::string (*text)(const nlohmann::json&),
                            const Command& command) {
  if (info && !command.json) fmt::print("{}", text(*info));
  return info;
}

}  // namespace

void add_info(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("info", "Describe a volume, scene or trajectory");
  auto path = std::make_shared<std::string>();
  auto quantity = std::make_shared<std::string>();
  auto options = std::make_shared<ModelOptions>();
  verb->add_option("file", *path, "Volume, DICOM folder, scene or trajectory")->required();
  add_shared(*verb, flags::quantity, *quantity, flags::quantity_default);
  add_model_options(*verb, *options);
  verb->callback([&command, path, quantity, options] {
    command.work = [path, quantity, options](const Command& chosen) -> Result<nlohmann::json> {
      std::error_code problem;
      if (!std::filesystem::exists(*path, problem)) return bad_use(*path, "no such file or folder");
      if (!std::filesystem::is_regular_file(*path, problem) && !std::filesystem::is_directory(*path, problem))
        return bad_use(*path, "is not a regular file");  // opening a pipe would wait for its writer
      const auto is = [ending = ending_of(*path)](std::string_view one) { return ending == one; };
      const bool trajectory = is(".h5") || is(".hdf5") || is_trajectory(*path);
      const std::string for_models = model_option(*options);
      if (trajectory && (!quantity->empty() || !for_models.empty()))
        return bad_use(quantity->empty() ? for_models : "--quantity",
                       "does not apply to trajectories, and " + *path + " is one; leave it out");
      if (trajectory) return said(trajectory_info(*path), trajectory_info_text, chosen);
      const bool volume_asked = may_be_volume(*path);
      if (!volume_asked && !quantity->empty())
        return bad_use("--quantity", "applies only to volumes, and " + *path + " is not one; leave it out");
      if (volume_asked && !for_models.empty())
        return bad_use(for_models, "applies only to models, and " + *path + " is a volume; leave it out");
      if (is(".toml") || is(".xml") || is(".urdf") || is(".mjcf") || is(".osim"))
        return said(scene_info(chosen, *path, *options), scene_info_text, chosen);
      if (volume_asked) return volume(*path, *quantity, chosen);
      return bad_use(*path, is(".csv") ? "is a table without the trajectory's details; name the .h5 file"
                                       : "is not a volume, scene or trajectory that this program reads");
    };
  });
}

}  // namespace borelli
