// borelli skeleton: from an inertia table and landmarks to a scene, or to a model of another program.
#include "pipeline/body/skeleton.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "dynamics/formats/model_write.hpp"
#include "error/file_ending.hpp"
#include "pipeline/body/belonging.hpp"
#include "pipeline/export/body_model.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

struct SkeletonAsked {
  std::string table, landmarks, meshes, output;
};

// The triangle files in a folder, as a model in `beside` (absolute) refers to them.
Result<std::vector<fs::path>> mesh_files_in(const fs::path& folder, const fs::path& beside) {
  std::vector<fs::path> out;
  if (folder.empty()) return out;
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(folder, problem))
    if (ending_of(entry.path()) == ".stl")
      out.push_back(fs::absolute(entry.path()).lexically_proximate(beside));
  if (problem) return failure(folder.string(), "cannot be read: " + problem.message());
  std::ranges::sort(out);
  if (out.empty())
    return bad_use(folder.string(), "contains no .stl file; write meshes with `borelli export --stl`");
  return out;
}

// A scene holds its solids alone; models of other programs also hold landmarks, deviations and meshes.
Result<WrittenModel> written(const SkeletonAsked& asked, const Scene& scene, const InertiaTable& table,
                             const PartInertials& parts, const Landmarks& landmarks) {
  if (ending_of(asked.output) == ".toml") {
    if (!asked.meshes.empty())
      return bad_use(
          asked.output,
          "is a scene file, which cannot refer to meshes; leave out --meshes, or write .osim, .xml or .urdf");
    return write_model(scene, asked.output);
  }
  const auto meshes = mesh_files_in(asked.meshes, fs::absolute(asked.output).parent_path());
  if (!meshes) return tl::unexpected(meshes.error());
  return write_model(with_landmark_markers(scene, parts, landmarks), asked.output,
                     body_extras(table, parts, landmarks, *meshes));
}

Result<nlohmann::json> work(const SkeletonAsked& asked, const Command& command) {
  if (auto fine = check_model_ending(asked.output); !fine) return tl::unexpected(fine.error());
  if (auto fine = check_writable(asked.output); !fine) return tl::unexpected(fine.error());
  const auto table = read_table(command, asked.table);
  if (!table) return tl::unexpected(table.error());
  const auto given = read_given_landmarks(command, asked.landmarks);
  if (!given) return tl::unexpected(given.error());
  auto apart = compare_centres(*table, given->all());
  if (!apart) return tl::unexpected(apart.error());
  command.warn(*apart);
  std::vector<Warning> warnings;
  SkeletonOptions options;
  options.absent = stated_absent(*table);
  const PartInertials parts = movable_parts(*table, warnings);
  const auto skeleton = build_skeleton(parts, given->all(), options);
  if (!skeleton) return tl::unexpected(skeleton.error());
  const auto model = written(asked, skeleton->scene, *table, parts, given->all());
  if (!model) return tl::unexpected(model.error());
  if (auto done = write_whole(asked.output, model->text); !done) return tl::unexpected(done.error());
  warnings.insert(warnings.end(), skeleton->warnings.begin(), skeleton->warnings.end());
  command.warn(in_sentences(warnings));
  for (const std::string& omission : model->omissions)
    command.warn("the written file lacks or changes: " + omission);
  if (!command.json) fmt::print("{}: {} solids\n", asked.output, skeleton->scene.solids.size());
  return nlohmann::json{
      {"scene", asked.output}, {"solids", skeleton->scene.solids.size()}, {"omissions", model->omissions}};
}

}  // namespace

void add_skeleton(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("skeleton", "Build a scene that moves from an inertia table and joint centres");
  auto asked = std::make_shared<SkeletonAsked>();
  verb->add_option("table", asked->table, "Inertia table (.json)")->required();
  add_shared(*verb, flags::landmarks, asked->landmarks)->required();
  add_output(*verb, asked->output, "FILE", "Scene (.toml) or model (.osim, .xml, .mjcf, .urdf) to write")
      ->required();
  verb->add_option("--meshes", asked->meshes,
                   "Folder of the parts' meshes (.stl, as `export` writes them) that a model refers to")
      ->type_name("FOLDER");
  verb->callback(
      [&command, asked] { command.work = [asked](const Command& chosen) { return work(*asked, chosen); }; });
}

}  // namespace borelli
