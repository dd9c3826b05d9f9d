// The verb `report`, which reads a whole folder of a run.
#include <map>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "tests/mutation/model_trial.hpp"
#include "tests/mutation/volume_trial.hpp"

namespace borelli::mutation {
namespace of_report {

namespace fs = std::filesystem;

const std::map<std::string, std::string> places{{"run.json", "run.json"},
                                                {"landmarks.json", "segmentation/landmarks.json"},
                                                {"segmentation.json", "segmentation/segmentation.json"},
                                                {"table.json", "inertia/table.json"},
                                                {"trajectory.h5", "motion/trajectory.h5"}};

std::vector<TestCase> seeds() {
  TestCase test{"folder", {}};
  test.files.push_back(
      {"landmarks.json",
       R"({"frame": "LPS", "unit": "mm", "landmarks": {"hip_left": {"point": [80, -20, 900]}}})"});
  test.files.push_back({"run.json", R"({"program": "borelli 0", "inputs": {"volume": [{"file": "a.nii",
 "sha256": "01"}]}, "settings": {"mesh_tolerance_mm": 1}, "stages": [{"stage": "inertia", "seconds": 0.5,
 "peak_memory_mib": 10, "mass_kg": 70, "outputs": {"inertia/table.json": 20}, "warnings": ["heavy"]}],
 "slowest": [{"stage": "inertia", "seconds": 0.5, "share": 1}]})"});
  test.files.push_back({"segmentation.json", R"({"input": "", "reading": "as hu", "convention": "deleva1996",
 "parts": {"head": {"label": 1, "coverage": "whole", "volume_mm3": 4e6, "confidence": 0.9, "note": ""}},
 "warnings": ["a table was taken away"]})"});
  for (const TestCase& table : find_reader("table")->seeds())
    if (table.name == "json") test.files.push_back({"table.json", table.files[0].bytes});
  for (const TestCase& sample : sample_cases({"pendulum.toml"})) {
    Scene scene = parse_scene(sample.files[0].bytes, sample.name).value();
    scene.simulation.end_time = 0.02, scene.simulation.output_interval = 0.01;
    const Trajectory motion = simulate(compile(scene).value()).value();
    test.files.push_back({"trajectory.h5", written("a.h5", [&](const std::string& path) {
                            return write_trajectory(motion, write_scene(scene).value(), path);
                          })});
  }
  // one case per file: the first file of a case is damaged most often
  std::vector<TestCase> out;
  for (std::size_t n = 0; n < test.files.size(); ++n) {
    out.push_back(test);
    out.back().name = test.files[n].name.substr(0, test.files[n].name.find('.'));
    std::swap(out.back().files[0], out.back().files[n]);
  }
  return out;
}

Result<void> read(const fs::path& file) {
  const fs::path folder = file.parent_path() / "out";
  for (const auto& [name, place] : places) {
    fs::create_directories((folder / place).parent_path());
    if (fs::exists(file.parent_path() / name)) fs::copy_file(file.parent_path() / name, folder / place);
  }
  return run_verb({"report", folder.string()});
}

}  // namespace of_report

Reader report_reader() { return {"report", of_report::seeds, of_report::read, true}; }

}  // namespace borelli::mutation
