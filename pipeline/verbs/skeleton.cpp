// borelli skeleton: from an inertia table and landmarks to a scene.
#include "pipeline/body/skeleton.hpp"

#include <fmt/core.h>

#include <memory>

#include "dynamics/formats/scene_file.hpp"
#include "pipeline/body/belonging.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

struct SkeletonAsked {
  std::string table, landmarks, out;
  SkeletonOptions options;
};

Result<nlohmann::json> work(const SkeletonAsked& asked, const Command& command) {
  if (auto fine = check_writable(asked.out, {asked.table, asked.landmarks}); !fine)
    return tl::unexpected(fine.error());
  const auto table = read_table(command, asked.table);
  if (!table) return tl::unexpected(table.error());
  const auto given = read_given_landmarks(command, asked.landmarks);
  if (!given) return tl::unexpected(given.error());
  auto apart = compare_centres(*table, given->all());
  if (!apart) return tl::unexpected(apart.error());
  command.warn(*apart);
  std::vector<Warning> warnings;
  SkeletonOptions options = asked.options;
  options.absent = told_absent(*table);
  const auto skeleton = build_skeleton(movable_parts(*table, warnings), given->all(), options);
  if (!skeleton) return tl::unexpected(skeleton.error());
  const auto text = write_scene(skeleton->scene);
  if (!text) return tl::unexpected(text.error());
  if (auto written = write_whole(asked.out, *text); !written) return tl::unexpected(written.error());
  warnings.insert(warnings.end(), skeleton->warnings.begin(), skeleton->warnings.end());
  command.warn(in_sentences(warnings));
  if (!command.json) fmt::print("{}: {} solids\n", asked.out, skeleton->scene.solids.size());
  return nlohmann::json{{"scene", asked.out}, {"solids", skeleton->scene.solids.size()}};
}

}  // namespace

void add_skeleton(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("skeleton", "Build a scene that moves from an inertia table and joint centres");
  auto asked = std::make_shared<SkeletonAsked>();
  verb->add_option("table", asked->table, "Inertia table (.json)")->required();
  verb->add_option("--landmarks", asked->landmarks,
                   "Joint centres and bony points (.json, .mrk.json or .fcsv)")
      ->required();
  verb->add_option("-o,--out", asked->out, "Scene to write (.toml)")->required();
  verb->add_option("--name", asked->options.name, "Name of the scene")->capture_default_str();
  verb->callback(
      [&command, asked] { command.work = [asked](const Command& chosen) { return work(*asked, chosen); }; });
}

}  // namespace borelli
