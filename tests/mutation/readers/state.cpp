// States of a scene as JSON: --state of evaluate (and of equilibrium and modes).
#include "tests/mutation/model_trial.hpp"

namespace borelli::mutation {
namespace of_state {

std::vector<TestCase> seeds() {
  std::vector<TestCase> out;
  for (const auto& [sample, state] : {std::pair<std::string, std::string>{
                                          "turntable.toml",
                                          "{\"t\": 0.5, \"q\": [0.4, 0.1, 0.1, 1, 0, 0, 0],\n \"v\": "
                                          "[0, 0.5, 0, 2.3e1, 0, 3], \"efforts\": [0, 0, 1, 0, 0, 0.25]}\n"},
                                      {"pendulum.toml", "{\"q\": [1.5]}"}})
    for (TestCase test : sample_cases({sample})) {
      test.files.insert(test.files.begin(), {"a.json", state});
      out.push_back(std::move(test));
    }
  return out;
}

Result<void> read(const std::filesystem::path& file) {
  for (const auto& entry : std::filesystem::directory_iterator(file.parent_path()))
    if (entry.path() != file) return run_verb({"evaluate", entry.path().string(), "--state", file.string()});
  return {};
}

}  // namespace of_state

Reader state_reader() { return {"state", of_state::seeds, of_state::read}; }

}  // namespace borelli::mutation
