#include "tests/mutation/model_trial.hpp"

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "tests/paths.hpp"

namespace borelli::mutation {

namespace fs = std::filesystem;

tl::unexpected<Error> in_file(const std::string& file, Error error) {
  if (!error.where.starts_with(file)) error.where = error.where.empty() ? file : file + ", " + error.where;
  return tl::unexpected(std::move(error));
}

Result<void> try_model(const fs::path& path) {
  const std::string file = path.string();
  const bool floating = path.filename().string().starts_with("floating");
  ModelOptions options;
  options.floating = floating;
  const auto model = read_model(file, options);
  if (!model) return tl::unexpected(model.error());
  const auto system = compile(model->scene);
  if (!system) return in_file(file, system.error());
  std::vector<std::string> words{"info", file};
  if (floating) words.emplace_back("--floating");
  if (auto info = run_verb(words); !info) return info;
  if (const auto text = write_scene(model->scene))
    if (const auto again = parse_scene(*text, file); !again)
      return defect("the scene that is written of it is refused: " + again.error().message());
  const auto numbers = evaluate(*system, system->initial);
  if (!numbers) return in_file(file, numbers.error());
  Observer observer;
  int steps = 0;
  observer.progress = [&](double) { return ++steps < 5; };
  observer.limits.evaluations = 500;
  const auto motion = simulate(*system, system->initial, system->settings, observer);
  if (!motion) return in_file(file, motion.error());
  if (motion->times.empty()) return defect("a motion without rows");
  return {};
}

std::vector<TestCase> sample_cases(const std::vector<std::string>& names) {
  std::vector<TestCase> out;
  for (const std::string& name : names) {
    const fs::path path = fs::path(test::source_folder()) / "samples" / name;
    out.push_back({path.stem().string(), {{name, bytes_of(path)}}});
  }
  return out;
}

std::vector<TestCase> shared_cases(const std::vector<std::string>& paths) {
  std::vector<TestCase> out;
  for (const std::string& name : paths) {
    const fs::path path = fs::path(test::shared_folder()) / name;
    if (fs::exists(path)) out.push_back({path.stem().string(), {{path.filename().string(), bytes_of(path)}}});
  }
  return out;
}

std::string tetrahedron_stl() {
  const float corners[4][3] = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}, {0, 0, 0.1F}};
  const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  std::string out = "by hand" + std::string(73, ' ') + std::string("\4\0\0\0", 4);
  for (const auto& face : faces) {
    out += std::string(12, '\0');
    for (const int corner : face) out.append(reinterpret_cast<const char*>(corners[corner]), 12);
    out += std::string(2, '\0');
  }
  return out;
}

}  // namespace borelli::mutation
