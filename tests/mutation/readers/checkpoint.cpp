// Checkpoints of an interrupted run.
#include "pipeline/verbs/checkpoint.hpp"

#include <regex>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/numbers/keeper.hpp"
#include "tests/mutation/dicom_bytes.hpp"
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_checkpoint {

namespace fs = std::filesystem;

struct Run {
  std::string text;
  System system;
};

Run run_of(const std::string& sample) {
  const std::string text = bytes_of(sample);
  return {text, compile(parse_scene(text, sample).value()).value()};
}

// Appends eight bytes: the checksum of all bytes after the first line.
std::string with_checksum(const std::string& bytes) {
  const auto line = bytes.find('\n');
  return bytes +
         little_endian(checksum_of(std::string_view(bytes).substr(line == bytes.npos ? 0 : line + 1)));
}

// Resumes from the file, if it exists, and stops at the fifth step.
Result<void> resume(const Run& run, const fs::path& file) {
  CheckpointFile kept(file.string(), 1e9);
  Observer observer;
  int steps = 0;
  observer.progress = [&](double) { return ++steps < 5; };
  observer.limits.evaluations = 2000;
  if (auto fine = kept.watch(run.text, observer); !fine) return fine;
  const auto motion = simulate(run.system, run.system.initial, run.system.settings, observer);
  kept.run_is_over();
  if (!motion && motion.error().where == "checkpoint")  // as the verb says it
    return tl::unexpected(Error{file.string(), motion.error().what, motion.error().kind});
  if (!motion) return in_file(file.string(), motion.error());
  return {};
}

std::vector<TestCase> seeds() {
  std::vector<TestCase> out;
  // each sample by its own method, and by those that keep other things between steps
  const std::vector<std::pair<std::string, std::string>> runs = {
      {"pendulum", ""},        {"turntable", ""},
      {"bouncing_ball", ""},   {"block_on_slope", ""},
      {"four_bar_2", ""},      {"four_bar_2", "generalized_alpha"},
      {"andrews", "gbs"},      {"andrews", "gauss16"},
      {"heavy_top", "gauss4"}, {"block_on_slope", "moreau"}};
  for (const auto& [sample, method] : runs) {
    TestCase test = sample_cases({sample + ".toml"}).front();
    if (!method.empty()) {
      test.name += "_" + method;
      std::string& text = test.files[0].bytes;
      text =
          std::regex_replace(text, std::regex("\nmethod = \"[a-z0-9_]*\""), "\nmethod = \"" + method + "\"");
    }
    const fs::path folder = fs::temp_directory_path() / ("borelli-checkpoint-" + test.name);
    write_case(test, folder);
    const fs::path file = folder / "a.checkpoint";
    static_cast<void>(resume(run_of((folder / test.files[0].name).string()), file));
    const std::string bytes = bytes_of(file);
    fs::remove_all(folder);
    if (bytes.size() < 8) continue;
    test.files.insert(test.files.begin(), {"a.checkpoint", bytes.substr(0, bytes.size() - 8), with_checksum});
    out.push_back(test);
  }
  return out;
}

Result<void> read(const fs::path& file) {
  for (const auto& entry : fs::directory_iterator(file.parent_path())) {
    if (entry.path().extension() != ".toml") continue;
    const std::string text = bytes_of(entry.path());
    const auto scene = parse_scene(text, entry.path().string());
    if (!scene) return tl::unexpected(scene.error());
    auto system = compile(*scene);
    if (!system) return failure(entry.path().string(), system.error().message());
    return resume({text, std::move(*system)}, file);
  }
  return {};
}

}  // namespace of_checkpoint

Reader checkpoint_reader() { return {"checkpoint", of_checkpoint::seeds, of_checkpoint::read}; }

}  // namespace borelli::mutation
