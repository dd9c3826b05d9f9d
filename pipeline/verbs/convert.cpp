// borelli convert MODEL -o FILE: a scene or model in another format.
#include <fmt/core.h>

#include <filesystem>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

struct ConvertAsked {
  std::string model, output;
  ModelOptions options;
};

Result<json> convert(const ConvertAsked& asked, const Command& command) {
  if (auto fine = check_model_ending(asked.output); !fine) return tl::unexpected(fine.error());
  if (auto fine = check_writable(asked.output); !fine) return tl::unexpected(fine.error());
  const auto model = read_model(command, asked.model, asked.options);
  if (!model) return tl::unexpected(model.error());
  const auto system = compile(model->scene);
  if (!system) return in_file(asked.model, system.error());
  const std::string source = std::filesystem::path(asked.model).filename().string();
  std::vector<std::string> comments{fmt::format("Converted from {} by borelli " BORELLI_VERSION, source)};
  for (const std::string& warning : command.warnings_in_files()) comments.push_back("Warning: " + warning);
  const auto written =
      write_model(model->scene, asked.output, {.meshes = {}, .comments = std::move(comments)});
  if (!written) return tl::unexpected(written.error());
  if (auto done = write_whole(asked.output, written->text); !done) return tl::unexpected(done.error());
  for (const std::string& omission : written->omissions)
    command.warn("the written file lacks or changes: " + omission);
  if (!command.json)
    fmt::print("wrote {}: {} solids, {} free coordinates\n", asked.output, model->scene.solids.size(),
               system->nv);
  return json{{"file", asked.output},
              {"solids", model->scene.solids.size()},
              {"velocities", system->nv},
              {"omissions", written->omissions}};
}

}  // namespace

void add_convert(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("convert", "Write a scene or model in another format");
  auto asked = std::make_shared<ConvertAsked>();
  verb->add_option("model", asked->model, "Scene or model: .toml, .xml (MJCF), .urdf or .osim")->required();
  add_output(*verb, asked->output, "FILE",
             "File to write; its ending says the format: .xml or .mjcf, .urdf, .osim, .toml")
      ->required();
  add_model_options(*verb, asked->options);
  verb->callback(
      [&command, asked] { command.work = [asked](const Command& c) { return convert(*asked, c); }; });
}

}  // namespace borelli
