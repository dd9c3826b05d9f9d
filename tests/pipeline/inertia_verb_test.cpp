// `borelli inertia` as a user runs it: inputs, table, exit codes and messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "inertia/csv.hpp"
#include "inertia/table_file.hpp"
#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"
#include "segmentation/files/write.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;

class InertiaVerb : public testing::Test {
 protected:
  void SetUp() override {
    const Phantom phantom = build_phantom({}).value();
    GridOptions grid;
    grid.spacing.setConstant(8);
    grid.rotation_deg << 3, 5, -8;  // so that the file's rounded grids differ in their last digits
    Scan scan = voxelise(phantom, phantom_grid(phantom, grid));
    for (const Part& part : parts)
      scan.labels.names.resize(parts.size()),
          scan.labels.names[static_cast<std::size_t>(part_label(part.name))] = part.name;
    scan.labels.names[0] = "outside";
    ASSERT_TRUE(write_volume(folder / "body.nii.gz", scan.grey));
    ASSERT_TRUE(write_labels(folder / "labels.nrrd", scan.labels));
    ASSERT_TRUE(write_landmarks(folder / "landmarks.json", phantom.landmarks));
    mass = phantom.whole.mass;
  }

  std::string file(const char* name) const { return (folder / name).string(); }
  std::string inputs() const {
    return " --volume " + file("body.nii.gz") + " --labels " + file("labels.nrrd");
  }

  const TestFolder folder;
  double mass = 0;
};

TEST_F(InertiaVerb, CsvJsonAndAnswerAgree) {
  const ProgramRun answer =
      run_program("inertia" + inputs() + " --landmarks " + file("landmarks.json") +
                  " --sex male --pose standing --json -o " + file("t.csv") + " -o " + file("t.json"));
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto table = read_table(file("t.json"));
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_NEAR(table->whole.inertial.mass / mass, 1, 0.003);  // 8 mm
  EXPECT_EQ(table->rows.size(), 16u);
  EXPECT_EQ(table->source.density_curve, "schneider2000");
  EXPECT_NE(table->source.quantity.find("CT numbers"), std::string::npos);
  const auto answered = nlohmann::json::parse(answer.out);
  EXPECT_EQ(answered.at("body").at("mass_kg").get<double>(), table->whole.inertial.mass);
  std::ifstream csv(file("t.csv"));
  const auto rows = parse_csv(std::string(std::istreambuf_iterator<char>(csv), {}), "t.csv");
  ASSERT_TRUE(rows) << rows.error().message();
  ASSERT_EQ(rows->rows.size(), 17u);
  double sum = 0;
  for (std::size_t n = 0; n < 16; ++n) sum += rows->number(n, "mass_kg");
  EXPECT_NEAR(sum, rows->number(16, "mass_kg"), 1e-6);
  EXPECT_EQ(folder.count(), 6);  // no partly written file remains
}

TEST_F(InertiaVerb, PrintsPartsAndPublishedValues) {
  const ProgramRun answer =
      run_program("inertia" + inputs() + " --landmarks " + file("landmarks.json") + " --sex female");
  ASSERT_EQ(answer.code, 0);
  for (const char* word : {"thigh_left", "HJC-KJC", "14.78", "36.1", "body", "schneider2000", "deleva1996"})
    EXPECT_NE(answer.out.find(word), std::string::npos) << word;
  // without landmarks no lengths can be compared
  const ProgramRun bare = run_program("inertia" + inputs());
  EXPECT_EQ(bare.code, 0);
  EXPECT_EQ(bare.out.find("HJC-KJC"), std::string::npos);
}

TEST_F(InertiaVerb, ComparesTablesAndRefusesOtherConventions) {
  const std::string common = "inertia" + inputs() + " --landmarks " + file("landmarks.json") + " --sex male";
  ASSERT_EQ(run_program(common + " -o " + file("a.json")).code, 0);
  ASSERT_EQ(run_program(common + " --density-curve geant4 -o " + file("b.json")).code, 0);
  ASSERT_EQ(run_program(common + " --convention bone -o " + file("c.json")).code, 0);
  const std::string pair = "inertia --compare " + file("a.json") + " " + file("b.json");
  const ProgramRun answer = run_program(pair + " --json -o " + file("d.csv"));
  ASSERT_EQ(answer.code, 0) << answer.err;
  EXPECT_NE(answer.err.find("density curves differ"), std::string::npos);
  const auto json = nlohmann::json::parse(answer.out);
  bool found = false;
  for (const auto& one : json.at("differences"))
    if (one.at("part") == "body" && one.at("entry") == "mass_kg") {
      found = true;  // density.hpp: -0.87 and +0.54 % on the ICRP male, another body
      EXPECT_NEAR(one.at("percent").get<double>(), -1.4, 0.6);
    }
  EXPECT_TRUE(found);
  EXPECT_TRUE(fs::exists(file("d.csv")));
  const ProgramRun refused = run_program("inertia --compare " + file("a.json") + " " + file("c.json"));
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("cuts follow bone"), std::string::npos) << refused.err;
  EXPECT_EQ(run_program("inertia --compare " + file("a.json")).code, 2);
  EXPECT_EQ(run_program(pair + inputs()).code, 2);
  EXPECT_EQ(run_program("inertia").code, 2);
}

TEST_F(InertiaVerb, WarnsOfLabelsThatDoNotFitTheScan) {
  EXPECT_EQ(run_program("inertia" + inputs()).err.find("do not fit"), std::string::npos);
  const auto labels = read_labels(file("labels.nrrd"));
  ASSERT_TRUE(labels) << labels.error().message();
  LabelMap off = *labels;
  std::ranges::rotate(off.voxels, off.voxels.begin() + 8);  // 64 mm along x
  ASSERT_TRUE(write_labels(folder / "off.nrrd", off));
  const ProgramRun told = run_program("inertia --volume " + file("body.nii.gz") + " --labels " +
                                      file("off.nrrd") + " -o " + file("off.json"));
  EXPECT_EQ(told.code, 0);
  EXPECT_NE(told.err.find("the labels do not fit the scan"), std::string::npos) << told.err;
  const auto table = read_table(file("off.json"));
  ASSERT_TRUE(table) << table.error().message();
  for (const InertiaRow& row : table->rows)
    if (row.part.starts_with("forearm") || row.part.starts_with("shank")) {
      EXPECT_EQ(row.completeness, Completeness::cut) << row.part;
      ASSERT_FALSE(row.notes.empty()) << row.part;
      EXPECT_NE(row.notes.front().find("air outside the body"), std::string::npos) << row.notes.front();
    }
  EXPECT_EQ(table->whole.completeness, Completeness::cut);
}

// The slices from `first` to before `last` of a volume.
template <class V>
V slices(const V& whole, std::int64_t first, std::int64_t last) {
  V part = whole;
  part.grid.size[2] = last - first;
  part.grid.origin = whole.grid.point(0, 0, first);
  const auto at = [&](std::int64_t k) {
    return whole.voxels.begin() + static_cast<std::ptrdiff_t>(whole.grid.offset(0, 0, k));
  };
  part.voxels.assign(at(first), at(last));
  return part;
}

// Scan and labels of different extent. The middle of the slices lies in the thighs' or the trunk's middle, so
// the parts on both sides of it are cut, whichever of the two ends there.
TEST_F(InertiaVerb, PartsAtTheEndOfTheScanOrOfTheLabelsAreCut) {
  const auto labels = read_labels(file("labels.nrrd"));
  ASSERT_TRUE(labels) << labels.error().message();
  const auto scan = read_volume(file("body.nii.gz"));
  ASSERT_TRUE(scan) << scan.error().message();
  const std::int64_t count = labels->grid.size[2], half = count / 2;
  std::array<std::array<std::int64_t, 2>, 256> voxels{};  // below and above
  for (std::int64_t k = 0; k < count; ++k)
    for (std::int64_t j = 0; j < labels->grid.size[1]; ++j)
      for (std::int64_t i = 0; i < labels->grid.size[0]; ++i)
        ++voxels[labels->at(i, j, k)][static_cast<std::size_t>(k >= half)];
  ASSERT_TRUE(write_volume(folder / "half.nii.gz", slices(scan->volume, 0, half)));
  ASSERT_TRUE(write_labels(folder / "half.nrrd", slices(*labels, 0, half)));
  const auto table_of = [&](const char* volume, const char* map) {
    const ProgramRun run = run_program("inertia --force --volume " + file(volume) + " --labels " + file(map) +
                                       " -o " + file("half.json"));
    EXPECT_EQ(run.code, 0) << run.err;
    return std::pair(read_table(file("half.json")), run.err);
  };
  const auto [short_scan, told] = table_of("half.nii.gz", "labels.nrrd");
  const auto [short_labels, silent] = table_of("body.nii.gz", "half.nrrd");
  EXPECT_NE(told.find("voxels outside the scan were left out: "), std::string::npos) << told;
  EXPECT_EQ(silent.find("outside the scan"), std::string::npos) << silent;
  int cut = 0;
  for (const auto* table : {&short_scan, &short_labels}) {
    ASSERT_TRUE(*table) << table->error().message();
    for (const InertiaRow& row : (*table)->rows) {
      const auto& [below, above] = voxels[static_cast<std::size_t>(part_label(row.part))];
      EXPECT_EQ(row.completeness, below == 0  ? Completeness::absent
                                  : above > 0 ? Completeness::cut
                                              : Completeness::whole)
          << row.part;
      cut += below > 0 && above > 0;
    }
  }
  EXPECT_GT(cut, 4);
}

TEST_F(InertiaVerb, UsesTheCutsOfTheFindings) {
  folder.write("segmentation.json", R"({"convention": "bone", "parts": {}})");
  const std::string found = "inertia" + inputs() + " --findings " + file("segmentation.json");
  const ProgramRun taken = run_program(found);
  EXPECT_EQ(taken.code, 0) << taken.err;
  EXPECT_NE(taken.out.find("Cuts: bone"), std::string::npos) << taken.out;
  EXPECT_EQ(run_program(found + " --convention bone").code, 0);
  const ProgramRun refused = run_program(found + " --convention deleva1996");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("were cut by bone"), std::string::npos) << refused.err;
  // an old segmentation.json without conventions
  folder.write("segmentation.json", R"({"parts": {}})");
  EXPECT_NE(run_program(found).out.find("Cuts: deleva1996"), std::string::npos);
  EXPECT_EQ(run_program(found + " --convention dempster").code, 0);
}

TEST_F(InertiaVerb, IsbFramesAreNamedOnlyIfPresent) {
  const std::string isb = "inertia" + inputs() + " --frames isb";
  const ProgramRun refused = run_program(isb);
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("add --landmarks"), std::string::npos) << refused.err;
  const ProgramRun full = run_program(isb + " --landmarks " + file("landmarks.json"));
  EXPECT_EQ(full.code, 0) << full.err;
  EXPECT_NE(full.out.find("frames: isb"), std::string::npos);
  // joints alone do not define ISB frames
  const Phantom phantom = build_phantom({}).value();
  Landmarks joints;
  for (const Part& part : parts)
    if (!part.joint.empty()) joints[std::string(part.joint)] = phantom.landmarks.find(part.joint)->second;
  ASSERT_TRUE(write_landmarks(folder / "joints.json", joints));
  const ProgramRun bare = run_program(isb + " --landmarks " + file("joints.json"));
  EXPECT_EQ(bare.code, 0) << bare.err;
  EXPECT_NE(bare.out.find("frames: joints"), std::string::npos) << bare.out;
  EXPECT_NE(bare.err.find("no segment has the landmarks of an ISB frame"), std::string::npos) << bare.err;
  EXPECT_NE(bare.out.find("no ISB frame, because a landmark is missing"), std::string::npos) << bare.out;
}

TEST_F(InertiaVerb, RefusesBadUseWithCodeTwo) {
  EXPECT_EQ(run_program("inertia --volume nowhere.nii.gz --labels " + file("labels.nrrd")).code, 2);
  EXPECT_EQ(run_program("inertia" + inputs() + " --density-curve mine").code, 2);
  EXPECT_EQ(run_program("inertia" + inputs() + " -o " + file("table.txt")).code, 2);
  EXPECT_EQ(run_program("inertia" + inputs() + " --quantity labels").code, 2);
  EXPECT_EQ(run_program("inertia" + inputs() + " --convention deleva96").code, 2);
  EXPECT_FALSE(fs::exists(file("table.txt")));
  const ProgramRun curve = run_program("inertia" + inputs() + " --density-curve mine");
  EXPECT_NE(curve.err.find("schneider2000"), std::string::npos) << curve.err;
}

}  // namespace
}  // namespace borelli
