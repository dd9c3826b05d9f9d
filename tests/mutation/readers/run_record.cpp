// run.json as a later run finds it, and segmentation.json, which stages read.
#include <filesystem>

#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/stages/stages.hpp"
#include "tests/mutation/reader.hpp"

namespace borelli::mutation {
namespace of_run_record {

namespace fs = std::filesystem;
using nlohmann::json;

// Three stages that depend on each other, like those of a run. A person may edit the second one's file.
std::vector<Stage> stages_in(const fs::path& folder) {
  const auto leave = [folder](const std::string& name) {
    return [=](const StageProgress&, const json& record) -> Result<json> {
      if (auto done = write_whole(folder / name, "text of " + name); !done)
        return tl::unexpected(done.error());
      return json{{"warnings", {"said by " + name}}, {"stages_before", record.at("stages").size()}};
    };
  };
  return {{"segmentation", {}, {{"grid", 3}}, {"w.txt"}, leave("w.txt")},
          {"inertia", {"segmentation"}, {{"sex", "male"}}, {"x.txt"}, leave("x.txt"), {{"x.txt"}}},
          {"motion", {"inertia"}, json::object(), {"y.txt"}, leave("y.txt")}};
}

const json head{{"program", "borelli 0"},
                {"inputs", {{"volume", {{{"file", "a.nii"}, {"sha256", "0123"}}}}}},
                {"settings", {{"mesh_tolerance_mm", 1}}}};

const std::string account = R"({"input": "a.nii", "reading": "as hu", "convention": "deleva1996", "parts": {
 "head": {"label": 1, "coverage": "whole", "volume_mm3": 4e6, "confidence": 0.9, "note": ""},
 "thigh_left": {"label": 11, "coverage": "cut", "volume_mm3": 1.5, "confidence": 0, "note": "at the edge"}},
 "warnings": ["a table was taken away"]}
)";

Result<json> run_in(const fs::path& folder) {
  const auto lock = FolderLock::take(folder);
  if (!lock) return tl::unexpected(lock.error());
  return run_stages(*lock, head, stages_in(folder), false, 1);
}

Result<void> read(const fs::path& file) {
  const auto record = run_in(file.parent_path());
  if (!record) return tl::unexpected(record.error());
  static_cast<void>(record->dump(-1, ' ', false, json::error_handler_t::replace));
  if (record->at("stages").size() != 3) return defect("not every stage is on the record");
  const fs::path findings = file.parent_path() / "segmentation.json";
  if (!fs::exists(findings)) return {};
  if (const auto convention = read_convention(findings); !convention)
    return tl::unexpected(convention.error());
  if (const auto parts = read_findings(findings); !parts) return tl::unexpected(parts.error());
  return {};
}

std::vector<TestCase> seeds() {
  const fs::path folder = fs::temp_directory_path() / "borelli-run-record";
  fs::remove_all(folder);
  static_cast<void>(run_in(folder).value());
  TestCase whole = read_case(folder);
  std::erase_if(whole.files, [](const TestFile& f) { return f.name.starts_with('.'); });
  whole.name = "whole";
  whole.files.insert(whole.files.begin() + 1, {"segmentation.json", account});
  fs::remove_all(folder);
  TestCase changed = whole;
  changed.name = "by_hand";
  for (TestFile& f : changed.files)
    if (f.name == "x.txt") f.bytes += ", changed by hand";
  return {whole, changed};
}

}  // namespace of_run_record

Reader run_record_reader() { return {"run_record", of_run_record::seeds, of_run_record::read}; }

}  // namespace borelli::mutation
