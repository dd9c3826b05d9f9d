// Trajectories as HDF5, and reference trajectories of charts as HDF5 or CSV.
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/export/reference_file.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "tests/mutation/model_trial.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_trajectory {

std::vector<TestCase> seeds() {
  std::vector<TestCase> out;
  for (const TestCase& sample : sample_cases({"pendulum.toml", "bouncing_ball.toml"})) {
    Scene scene = parse_scene(sample.files[0].bytes, sample.name).value();
    scene.simulation.end_time = 0.02, scene.simulation.output_interval = 0.01;
    const Trajectory motion = simulate(compile(scene).value()).value();
    for (const std::string file : {"a.h5", "a.csv"})
      out.push_back({sample.name + "_" + file.substr(2), {{file, written(file, [&](const std::string& path) {
                                                             return write_trajectory(
                                                                 motion, write_scene(scene).value(), path);
                                                           })}}});
  }
  // without the digest at its end, a damaged file reaches HDF5
  for (TestCase test : std::vector(out)) {
    std::string& bytes = test.files[0].bytes;
    const auto digest = bytes.rfind("\nborelli sha256 ");
    if (digest == bytes.npos || test.files[0].name != "a.h5") continue;
    bytes.resize(digest);
    test.name += "_without_digest";
    out.push_back(test);
  }
  return out;
}

Result<void> read(const std::filesystem::path& file) {
  if (file.extension() != ".csv") {
    const auto stored = read_trajectory(file);
    if (!stored) return tl::unexpected(stored.error());
    if (auto info = run_verb({"info", file.string()}); !info) return info;
  }
  const auto reference = read_reference(file, {"bob"});
  const auto other = reference ? reference : read_reference(file, {"ball"});
  if (!other) return tl::unexpected(other.error());
  if (other->poses.size() != other->times.size()) return defect("not one pose at each time");
  return {};
}

}  // namespace of_trajectory

Reader trajectory_reader() { return {"trajectory", of_trajectory::seeds, of_trajectory::read}; }

}  // namespace borelli::mutation
