// `borelli run` as a user runs it: stages repeated by a second run, two runs at once, files edited by hand.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "pipeline/export/mesh_file.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"
#include "tests/pipeline/run_verb.hpp"

namespace borelli::run_verb_test {
namespace {

using nlohmann::json;

TEST_F(RunVerb, RepeatsStagesWithMissingOrChangedFiles) {
  const std::string run = path("scan.mhd") + words();
  EXPECT_EQ(stages_done(run), all);
  EXPECT_EQ(stages_done(run), Names{});
  for (const char* model : {"model/body.osim", "model/body.xml"}) {
    const auto read = read_model(result(model));
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_FALSE(read->scene.markers.empty()) << model;
    EXPECT_NE(read_input_file(result(model)).value().find("../mesh/head.stl"), std::string::npos) << model;
  }
  const auto before = json::parse(read_input_file(result("run.json")).value());

  fs::remove(result("inertia/table.csv"));
  EXPECT_EQ(stages_done(run), Names{"inertia"});
  EXPECT_TRUE(fs::exists(result("inertia/table.csv")));
  const auto packed = [&] {  // the page's thumbnail of the scan and its moving body
    const std::string page = read_input_file(result("report.html")).value();
    const auto first = page.find("<script type=\"text/plain\"");
    return page.substr(std::min(first, page.size()));
  };
  const std::string shown = packed();
  fs::remove(result("report.html"));
  EXPECT_EQ(stages_done(run), Names{"report"});
  EXPECT_EQ(packed(), shown);
  EXPECT_NE(shown.find("block-grey"), std::string::npos);
  const std::string glb = read_input_file(result("body.glb")).value();
  fs::resize_file(result("body.glb"), glb.size() - 1);
  EXPECT_EQ(stages_done(run), Names{"glb"});
  EXPECT_EQ(read_input_file(result("body.glb")).value(), glb);
  fs::remove(result("mesh/head.stl"));
  EXPECT_EQ(stages_done(run), Names{"mesh"});

  EXPECT_EQ(stages_done(run + " --sex female"),
            (Names{"inertia", "skeleton", "motion", "models", "glb", "report"}));
  EXPECT_EQ(stages_done(run + " --sex female --tuck 0.5"),
            (Names{"skeleton", "motion", "models", "glb", "report"}));
  // reverted: the keys equal those of the first run
  EXPECT_FALSE(stages_done(run).empty());
  const auto after = json::parse(read_input_file(result("run.json")).value());
  for (std::size_t n = 0; n < before["stages"].size(); ++n)
    EXPECT_EQ(after["stages"][n]["key"], before["stages"][n]["key"]);

  EXPECT_EQ(stages_done(run + " --force"), all);
}

TEST_F(RunVerb, DefacingKeepsMeasurements) {
  const std::string scan_file = path("scan.mhd");
  stages_done(scan_file + words());
  const auto kept = [&](const char* name) { return read_input_file(result(name)).value_or(name); };
  std::map<std::string, std::string> before;
  for (const char* name :
       {"inertia/table.json", "inertia/table.csv", "segmentation/labels.nii.gz", "motion/trajectory.csv",
        "mesh/upper_trunk.stl", "mesh/head.stl", "mesh/head.vtp", "body.glb", "report.html"})
    before[name] = kept(name);
  EXPECT_EQ(stages_done(scan_file + words() + " --deface"),
            (Names{"mesh", "models", "glb", "slices", "report"}));
  for (const auto& [name, bytes] : before) {
    const bool shows_the_head = name.starts_with("mesh/head") || name == "body.glb" || name == "report.html";
    EXPECT_EQ(kept(name.c_str()) != bytes, shows_the_head) << name;
  }
  // the phantom faces -y: the rest of its head ends well behind the former face
  const auto foremost = [](const Mesh& mesh) {
    float least = 1e9F;
    for (const auto& point : mesh.points) least = std::min(least, point.y());
    return 1e3F * least;
  };
  folder.write("head.vtp", before["mesh/head.vtp"]);
  const auto whole = read_vtp(path("head.vtp")), left = read_vtp(result("mesh/head.vtp").string());
  ASSERT_TRUE(whole && left);
  EXPECT_GT(foremost(*left), foremost(*whole) + 30);  // 0.22 of a head's depth of about 190 mm, less a voxel
  EXPECT_NE(kept("settings.toml").find("deface = true"), std::string::npos);
  EXPECT_EQ(stages_done(scan_file + words()),
            (Names{"mesh", "models", "glb", "slices", "report"}));  // and back
  EXPECT_EQ(kept("mesh/head.stl"), before["mesh/head.stl"]);
}

TEST_F(RunVerb, KeepsAndUsesFilesEditedByHand) {
  const std::string run = path("scan.mhd") + words();
  EXPECT_EQ(stages_done(run), all);
  std::string scene = read_input_file(result("model/scene.toml")).value();
  const std::size_t at = scene.find("end_time = 0.1");
  ASSERT_NE(at, std::string::npos);
  scene[at + std::string("end_time = 0.").size()] = '2';  // same size
  ASSERT_TRUE(write_whole(result("model/scene.toml"), scene));
  EXPECT_EQ(stages_done(run), (Names{"motion", "models", "glb", "report"}));
  EXPECT_EQ(read_input_file(result("model/scene.toml")).value(), scene);
  const ProgramRun again = run_program("run " + run);
  const std::string said =
      "warning: skeleton: model/scene.toml was changed by hand and is kept; --force writes it";
  EXPECT_NE(again.err.find(said), std::string::npos) << again.err;

  // landmarks edited by hand, on which the table and all later stages depend; the edited scene stays
  const auto landmarks = read_landmarks(result("segmentation/landmarks.json").string());
  ASSERT_TRUE(landmarks);
  Landmarks moved = *landmarks;
  moved.at("knee_left").point.x() += 5;
  ASSERT_TRUE(write_landmarks(result("segmentation/landmarks.json").string(), moved));
  const std::string edited = read_input_file(result("segmentation/landmarks.json")).value();
  const std::string table = read_input_file(result("inertia/table.json")).value();
  EXPECT_EQ(stages_done(run), (Names{"inertia", "motion", "mesh", "models", "glb", "slices", "report"}));
  EXPECT_EQ(read_input_file(result("segmentation/landmarks.json")).value(), edited);
  EXPECT_EQ(read_input_file(result("model/scene.toml")).value(), scene);
  EXPECT_NE(read_input_file(result("inertia/table.json")).value(), table);

  fs::resize_file(result("segmentation/labels.nii.gz"), 100);
  expect_refused("run " + run, 2,
                 "landmarks.json: was changed by hand, but the stage 'segmentation' would overwrite it");
  EXPECT_EQ(read_input_file(result("segmentation/landmarks.json")).value(), edited);
  EXPECT_EQ(stages_done(run + " --force"), all);
  EXPECT_NE(read_input_file(result("segmentation/landmarks.json")).value(), edited);
}

TEST_F(RunVerb, ChangedVoxelMakesAnotherScan) {
  for (const char* header : {"scan.mhd", "scan.nhdr"}) {
    const std::string run = path(header) + words();
    EXPECT_EQ(stages_done(run), all) << header;
    std::fstream raw(folder / "scan.raw", std::ios::binary | std::ios::in | std::ios::out);
    raw.seekg(0, std::ios::end);
    const auto middle = raw.tellg() / 2;
    raw.seekg(middle);
    const char byte = static_cast<char>(raw.get() ^ 1);  // changes one voxel, not the header
    raw.seekp(middle);
    raw.put(byte).flush();
    EXPECT_EQ(stages_done(run), all) << header;
    const auto record = json::parse(read_input_file(result("run.json")).value());
    EXPECT_EQ(record["inputs"]["volume"][1]["file"], "scan.raw");
  }
  fs::remove(folder / "scan.raw");
  expect_refused("run " + path("scan.mhd") + words(), 2, "scan.raw', which does not exist");
}

// Starts the program and lets it run.
class ProgramAtWork {
 public:
  explicit ProgramAtWork(const std::string& arguments) : id_(fork()) {
    if (id_ != 0) return;
    execl("/bin/sh", "sh", "-c",
          ("exec " + test::program_path() + " " + arguments + " >/dev/null 2>&1").c_str(), nullptr);
    _exit(127);
  }
  ~ProgramAtWork() { kill(); }
  ProgramAtWork(const ProgramAtWork&) = delete;
  ProgramAtWork& operator=(const ProgramAtWork&) = delete;
  void halt() const { ::kill(id_, SIGSTOP); }
  void kill() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    waitpid(id_, nullptr, 0);
    id_ = -1;
  }

 private:
  pid_t id_;
};

TEST_F(RunVerb, ChangedOutputIsWrittenAgain) {
  const std::string run = path("scan.mhd") + words();
  EXPECT_EQ(stages_done(run), all);
  for (const auto& [name, stage] : {std::pair{"body.glb", "glb"},
                                    {"motion/trajectory.csv", "motion"},
                                    {"report.html", "report"},
                                    {"model/body.osim", "models"},
                                    {"segmentation/labels.ctbl", "segmentation"}}) {
    const std::string whole = read_input_file(result(name)).value();
    std::string other = whole;
    other[other.size() / 2] ^= 1;
    ASSERT_TRUE(write_whole(result(name), other));
    EXPECT_EQ(stages_done(run), Names{stage}) << name;
    if (std::string(name) != "report.html") {  // the report has the stages' times
      EXPECT_EQ(read_input_file(result(name)).value(), whole) << name;
    }
  }
}

TEST_F(RunVerb, RecordsEveryFileItWrites) {
  std::string walk = "walk\nversion=1\nnRows=20\nnColumns=2\ninDegrees=yes\nendheader\ntime\tknee_left\n";
  for (int row = 0; row < 20; ++row) walk += fmt::format("{}\t{}\n", 0.01 * row, row);
  folder.write("walk.mot", walk);
  std::string without_leap = words();
  without_leap.erase(without_leap.find(" --flight-time 0.1"), 18);
  for (const std::string& run :
       {path("scan.mhd") + words() + " --skin --segments trunk,thigh_left,thigh_right",
        path("scan.mhd") + words() + " --model-tolerance 50%",
        path("scan.mhd") + without_leap + " --band-draws 1 --motion " + path("walk.mot")}) {
    fs::remove_all(folder / "out");
    stages_done(run);
    auto [found, recorded] = found_and_recorded(folder / "out/s");
    recorded.insert({".lock", "run.json", "settings.toml"});  // of the run itself
    recorded.erase("body.png"), found.erase("body.png");      // only where the machine can draw
    EXPECT_EQ(found, recorded) << run;
  }
}

TEST_F(RunVerb, KeepsPointsMovedInSlicer) {
  const std::string run = path("scan.mhd") + words();
  stages_done(run);
  const fs::path points = result("segmentation/landmarks.mrk.json");
  const std::string whole = read_input_file(points).value();
  fs::remove(points);
  EXPECT_EQ(stages_done(run), Names{"segmentation"});
  EXPECT_EQ(read_input_file(points).value(), whole);
  // moved points stay, and the program says how they count
  std::string moved = whole;
  moved.insert(moved.rfind('}'), "\n");
  ASSERT_TRUE(write_whole(points, moved));
  const ProgramRun again = run_program("run " + run);
  EXPECT_NE(again.err.find("landmarks.mrk.json was changed by hand and is kept, although later stages read "
                           "segmentation/landmarks.json"),
            std::string::npos)
      << again.err;
  EXPECT_EQ(read_input_file(points).value(), moved);
  // given back, they are an input: no edit that a stage would overwrite
  EXPECT_TRUE(stages_done(path("scan.mhd") + words("s", "out/s/segmentation/landmarks.mrk.json"))
                  .contains("segmentation"));
  EXPECT_EQ(read_input_file(points).value(), moved);
}

// A file's text, with the report's packed blocks unpacked.
std::string text_of_output(const fs::path& file) {
  const auto read = read_input_file(file);
  EXPECT_TRUE(read) << file;
  if (!read) return "";
  const auto inflate_all = [](std::string_view packed, int form) {
    z_stream stream{};
    inflateInit2(&stream, form);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    std::string out;
    std::array<char, 65536> block;
    for (int done = Z_OK; done == Z_OK;) {
      stream.next_out = reinterpret_cast<Bytef*>(block.data());
      stream.avail_out = block.size();
      done = inflate(&stream, Z_NO_FLUSH);
      out.append(block.data(), block.size() - stream.avail_out);
    }
    inflateEnd(&stream);
    return out;
  };
  return read->starts_with("\x1f\x8b") ? inflate_all(*read, 31) : *read;
}

// Numbers alone could be any program's.
TEST_F(RunVerb, LabelsWithoutNamesAreRefused) {
  fs::remove(folder / "labels.tsv");
  const ProgramRun run = run_program("run " + path("scan.mhd") + words());
  EXPECT_EQ(run.code, 2) << run.err;
  EXPECT_NE(run.err.find("labels.nrrd: names none of the body's parts; put a names file beside it"),
            std::string::npos)
      << run.err;
  EXPECT_FALSE(fs::exists(result("report.html")));
}

TEST_F(RunVerb, OutputsDoNotNameTheInputsFolder) {
  const std::string patient = "DOE_JANE_19500101";
  fs::create_directories(folder / patient);
  for (const char* name : {"scan.mhd", "scan.raw", "labels.nrrd", "labels.tsv", "joints.json"})
    fs::rename(folder / name, folder / patient / name);
  const std::string own = path(patient + "/scan.mhd"), out = path("out");
  const auto named_in = [&](const std::string& below) {
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder / below))
      if (entry.is_regular_file() && text_of_output(entry.path()).find(patient) != std::string::npos)
        found.insert(entry.path().lexically_relative(folder / below).string());
    return found;
  };
  const std::string words = " --quantity hu --labels " + path(patient + "/labels.nrrd") + " --landmarks " +
                            path(patient + "/joints.json") +
                            " --flight-time 0.1 --mesh-tolerance-mm 3 --subject s -o ";
  EXPECT_EQ(stages_done(own + words + out), all);
  EXPECT_EQ(named_in("out"), Names{});
  EXPECT_EQ(stages_done(own + words + path("kept") + " --keep-paths"), all);
  EXPECT_TRUE(named_in("kept").contains("s/run.json"));
  EXPECT_TRUE(named_in("kept").contains("s/settings.toml"));

  const std::string parts = "segment " + own + " --quantity hu -o " + path("parts");
  ASSERT_EQ(run_program(parts).code, 0);
  EXPECT_EQ(named_in("parts"), Names{});
  ASSERT_EQ(run_program(parts + " --keep-paths").code, 0);
  EXPECT_EQ(named_in("parts"), Names{"segmentation.json"});
  fs::create_directories(folder / "tables");
  const std::string table = "inertia --volume " + own + " --quantity hu --labels " +
                            path(patient + "/labels.nrrd") + " -o " + path("tables/t.json") + " -o " +
                            path("tables/t.csv");
  ASSERT_EQ(run_program(table).code, 0);
  EXPECT_EQ(named_in("tables"), Names{});
  ASSERT_EQ(run_program(table + " --keep-paths").code, 0);
  EXPECT_EQ(named_in("tables"), (Names{"t.csv", "t.json"}));
}

TEST_F(RunVerb, RefusesOptionsOfTheOtherKindOfMotion) {
  const std::string run = "run " + path("scan.mhd") + words();  // with --flight-time
  const auto refuses = [](const std::string& command, const std::string& said) {
    const ProgramRun answer = run_program(command);
    EXPECT_EQ(answer.code, 2) << command;
    EXPECT_NE(answer.err.find(said), std::string::npos) << answer.err;
  };
  refuses(run + " --motion walk.mot", "--flight-time: shapes the leap, which --motion replaces");
  refuses(run + " --cut-off 3", "--cut-off: applies only to a recorded motion");
  const std::string captured = "run " + path("scan.mhd") + " -o " + path("captured") + " --motion walk.mot";
  for (const std::string option : {"--accuracy 1e-3", "--method rk4", "--equations lagrange"})
    refuses(captured + " " + option, option.substr(0, option.find(' ')) + ": shapes the leap");
  // settings that an earlier version stored contain the defaults
  const ProgramRun stored = run_program(captured + " --equations recursive --tuck 1.0");
  EXPECT_EQ(stored.err.find("shapes the leap"), std::string::npos) << stored.err;
}

TEST_F(RunVerb, FailedRunSaysEachWarningOnceAndWithoutFolders) {
  // labels that another program saved through floating point
  const LabelMap& labels = scan().labels;
  std::vector<float> saved(labels.voxels.begin(), labels.voxels.end());
  for (float& label : saved) label *= 1.0001F;
  const auto bytes = std::as_bytes(std::span(saved));
  folder.write("rounded.raw", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  std::string header = read_input_file(folder / "scan.mhd").value();
  header.replace(header.find("MET_SHORT"), 9, "MET_FLOAT");
  header.replace(header.find("scan.raw"), 8, "rounded.raw");
  folder.write("rounded.mhd", header);
  fs::copy_file(folder / "labels.tsv", folder / "rounded.tsv");
  folder.write("short.mot",
               "walk\nversion=1\nnRows=2\nnColumns=2\ninDegrees=yes\nendheader\ntime\tknee_left\n"
               "0\t0\n0.1\t5\n");
  const ProgramRun run = run_program("run " + path("scan.mhd") + " --labels " + path("rounded.mhd") +
                                     " --landmarks " + path("joints.json") + " --quantity hu --motion " +
                                     path("short.mot") + " --subject s -o " + path("out"));
  EXPECT_EQ(run.code, 2);
  const std::string said = "were rounded to whole numbers";
  const std::size_t first = run.err.find(said);
  EXPECT_NE(first, std::string::npos) << run.err;
  EXPECT_EQ(run.err.find(said, first + 1), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("segmentation: rounded.mhd: its labels"), std::string::npos) << run.err;
}

TEST_F(RunVerb, RefusesTwoRunsInOneFolder) {
  // The first run is halted as soon as its output shows that it has locked the folder.
  const std::string shared = "run " + path("scan.mhd") + " --quantity hu --subject s -o " + path("out");
  ProgramAtWork first(shared + " --pose waiting");
  for (int tries = 0; !fs::exists(result("settings.toml")); ++tries) {
    ASSERT_LT(tries, 30000) << "the first run did not begin within 30 s";
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  first.halt();
  const std::string settings = read_input_file(result("settings.toml")).value();
  EXPECT_NE(settings.find("waiting"), std::string::npos);
  expect_refused("run " + path("scan.mhd") + words(), 1, "another run is using this folder");
  EXPECT_EQ(read_input_file(result("settings.toml")).value(), settings);  // the first one's still

  first.kill();
  EXPECT_EQ(stages_done(path("scan.mhd") + words()), all);
}

}  // namespace
}  // namespace borelli::run_verb_test
