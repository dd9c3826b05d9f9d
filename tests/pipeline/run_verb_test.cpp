// `borelli run` as a user runs it, with the phantom's labels and joint centres: stages repeated by a second
// run, two runs at once, and reuse of settings.toml.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <chrono>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/motion_quantity.hpp"
#include "pipeline/export/mesh_file.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "samples/phantom.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/write.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::run_verb_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// one body for all tests; a coarse grid suffices to see which stages run
const Phantom& body() {
  static const Phantom made = build_phantom({}).value();
  return made;
}

const Scan& scan() {
  static const Scan made = [] {
    GridOptions grid;
    grid.spacing.setConstant(10);
    Scan drawn = voxelise(body(), phantom_grid(body(), grid));
    drawn.labels.names.assign(1, "outside");
    for (std::size_t label = 1; label < parts.size(); ++label)
      drawn.labels.names.emplace_back(parts[label].name);
    return drawn;
  }();
  return made;
}

class RunVerb : public testing::Test {
 protected:
  void SetUp() override {
    const Grid& g = scan().grey.grid;
    const auto voxels = std::as_bytes(std::span(scan().grey.voxels));
    ASSERT_TRUE(write_whole(folder / "scan.raw",
                            std::string_view(reinterpret_cast<const char*>(voxels.data()), voxels.size())));
    folder.write("scan.mhd",
                 fmt::format("ObjectType = Image\nNDims = 3\nDimSize = {} {} {}\nElementSpacing = 10 10 10\n"
                             "Offset = {} {} {}\nElementType = MET_SHORT\nElementDataFile = scan.raw\n",
                             g.size[0], g.size[1], g.size[2], g.origin[0], g.origin[1], g.origin[2]));
    folder.write(
        "scan.nhdr",
        fmt::format("NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n"
                    "space directions: (10,0,0) (0,10,0) (0,0,10)\nspace origin: ({},{},{})\n"
                    "endian: little\nencoding: raw\ndata file: scan.raw\n",
                    g.size[0], g.size[1], g.size[2], g.origin[0], g.origin[1], g.origin[2]));
    ASSERT_TRUE(write_labels((folder / "labels.nrrd").string(), scan().labels));
    ASSERT_TRUE(write_landmarks((folder / "joints.json").string(), body().landmarks));
  }

  std::string path(const std::string& name) const { return (folder / name).string(); }
  /// All arguments except the volume; results go to out/<subject>.
  std::string words(const std::string& subject = "s", const std::string& landmarks = "joints.json") const {
    return " --quantity hu --labels " + path("labels.nrrd") + " --landmarks " + path(landmarks) +
           " --flight-time 0.1 --mesh-tolerance-mm 3 --subject " + subject + " -o " + path("out");
  }
  fs::path result(const std::string& name) const { return folder / "out/s" / name; }

  /// Runs to the end and returns the executed stages, except the picture's, which every run tries again
  /// without a display.
  std::set<std::string> stages_done(const std::string& arguments) const {
    const ProgramRun run = run_program("run " + arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    std::set<std::string> done;
    std::istringstream said(run.err);
    for (std::string line; std::getline(said, line);) {
      const std::string stage = line.substr(0, line.find(' '));
      if (line.ends_with(" ...")) done.insert(stage);
      if (line.ends_with("already done")) done.erase(stage);
    }
    done.erase("picture");
    return done;
  }
  /// Expects one line on standard error that contains `said`, and no other output.
  void expect_refused(const std::string& arguments, int code, const std::string& said) const {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.code, code) << arguments << "\n" << run.err;
    EXPECT_TRUE(run.err.starts_with("borelli: ")) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    EXPECT_EQ(run.out, "");
  }

  const TestFolder folder;
};

using Names = std::set<std::string>;
const Names all{"segmentation", "inertia", "skeleton", "motion", "mesh", "models", "glb", "slices", "report"};

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

TEST_F(RunVerb, AccuracyChoosesTheMethodUnlessOneIsNamed) {
  const auto certificate_of = [&](const std::string& option) {
    stages_done(path("scan.mhd") + words() + option);
    return read_trajectory(result("motion/trajectory.h5"))->trajectory.certificate;
  };
  const Certificate usual = certificate_of("");
  EXPECT_TRUE(usual.trusted) << usual.reason;
  EXPECT_EQ(usual.accuracy, 1e-6);
  EXPECT_LE(usual.estimated_error, 1e-6);
  EXPECT_EQ(usual.method, "dop853");
  EXPECT_EQ(certificate_of(" --accuracy 1e-4").accuracy, 1e-4);
  const Certificate named = certificate_of(" --method rk4 --step 1e-3");
  EXPECT_EQ(named.accuracy, 0);
  EXPECT_EQ(named.method, "rk4");
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

TEST_F(RunVerb, StoredSettingsRepeatTheRun) {
  // names that look like numbers, a number without exact decimals, quotes
  const std::string run = path("scan.mhd") + words("007") +
                          " --keep-paths --pose \"on \\\"one's\\\" side\" --sex female --allow-untrusted"
                          " --tolerance 3.0000000000000004e-7 --somersault-rate -123.456 --tuck +.25"
                          " --density-curve mcsquare --method rk4_adaptive --muscle-frequency 1"
                          " --damping-ratio 0.7 --label-names " +
                          path("labels.tsv");
  EXPECT_EQ(stages_done(run), all);
  const std::string file = path("out/007/settings.toml");
  const std::string text = read_input_file(file).value();
  const auto record = json::parse(read_input_file(path("out/007/run.json")).value());
  EXPECT_EQ(record["settings"]["subject"], "007");
  EXPECT_EQ(record["settings"]["pose"], "on \"one's\" side");
  EXPECT_EQ(record["settings"]["integrator_tolerance"], 3.0000000000000004e-7);
  EXPECT_EQ(record["settings"]["leap"]["tuck"], 0.25);

  EXPECT_EQ(stages_done("--settings " + file), Names{});
  EXPECT_EQ(json::parse(read_input_file(path("out/007/run.json")).value())["settings"], record["settings"]);
  EXPECT_EQ(read_input_file(file).value(), text);
  // without paths, the run is the same wherever its inputs are
  EXPECT_EQ(stages_done("--settings " + file + " --keep-paths=false"), all);
  const std::string shared = read_input_file(file).value();
  EXPECT_EQ(shared.find(folder.path().string()), std::string::npos) << shared;
  EXPECT_NE(shared.find("run VOLUME --settings settings.toml --output FOLDER --labels labels.nrrd"),
            std::string::npos)
      << shared;
  fs::create_directories(folder / "moved");
  for (const char* name : {"scan.mhd", "scan.raw", "labels.nrrd", "labels.tsv", "joints.json"})
    fs::rename(folder / name, folder / "moved" / name);
  EXPECT_EQ(stages_done(path("moved/scan.mhd") + " --settings " + file + " -o " + path("out") + " --labels " +
                        path("moved/labels.nrrd") + " --label-names " + path("moved/labels.tsv") +
                        " --landmarks " + path("moved/joints.json")),
            Names{});
  EXPECT_EQ(read_input_file(file).value(), shared);
  for (const char* name : {"scan.mhd", "scan.raw", "labels.nrrd", "labels.tsv", "joints.json"})
    fs::rename(folder / "moved" / name, folder / name);
  EXPECT_EQ(stages_done("--settings " + file + ' ' + path("scan.mhd") + words("007") + " --label-names " +
                        path("labels.tsv") + " --keep-paths"),
            all);
  // the command line overrides the file
  EXPECT_EQ(stages_done("--settings " + file + " --tuck 0.5"),
            (Names{"skeleton", "motion", "models", "glb", "report"}));
}

TEST_F(RunVerb, SimulatesTheSmallestModelWithinATolerance) {
  const std::string run = path("scan.mhd") + words();
  Names with_economy = all;
  with_economy.insert("economy");
  EXPECT_EQ(stages_done(run + " --model-tolerance 1% --keep centre --keep turn:lower_trunk"), with_economy);
  const auto record = json::parse(read_input_file(result("run.json")).value());
  const json said = record["stages"][3]["economy"];
  const Scene whole = read_scene(result("model/scene.toml")).value(),
              small = read_scene(result("model/smallest.toml")).value();
  EXPECT_EQ(compile(small).value().nv, said["coordinates"].get<int>());
  EXPECT_LT(said["coordinates"].get<int>(), said["whole"]["coordinates"].get<int>());
  EXPECT_GT(said["search"]["runs"].get<int>(), 0);
  const auto moved = read_trajectory(result("motion/trajectory.h5"));
  ASSERT_TRUE(moved);
  EXPECT_EQ(int(moved->trajectory.v.cols()), said["coordinates"].get<int>());
  EXPECT_NE(read_input_file(result("report.html")).value().find(said["in_words"].get<std::string>()),
            std::string::npos);
  // both models by another method, much better
  const auto motion = [](Scene scene) {
    scene.simulation.method = "gbs", scene.simulation.tolerance = 1e-11;
    const System system = compile(scene).value();
    return simulate(system).value();
  };
  const Trajectory a = motion(whole), b = motion(small);
  const double length = compile(whole).value().length;
  double error = 0;
  for (const char* text : {"centre", "turn:lower_trunk"}) {
    const auto quantity = parse_motion_quantity(text, whole).value();
    for (std::size_t row = 0; row < a.times.size(); ++row)
      error = std::max(error, quantity_difference(quantity, a, b, row, length));
  }
  EXPECT_GT(error, 0);
  EXPECT_LE(error, 0.01);
  EXPECT_LE(error, said["error"].get<double>() + 2e-4);  // at output rows, to a hundredth

  EXPECT_EQ(
      stages_done("--settings " + result("settings.toml").string() + ' ' + path("scan.mhd") + " --labels " +
                  path("labels.nrrd") + " --landmarks " + path("joints.json") + " -o " + path("out")),
      Names{});
  EXPECT_EQ(stages_done(run), (Names{"motion", "glb", "report"}));
  EXPECT_FALSE(fs::exists(result("model/smallest.toml")));
  expect_refused("run " + run + " --keep centre", 2, "--keep: applies only with --model-tolerance");
  expect_refused("run " + run + " --model-tolerance 1e-6", 2, "is not between 0.1 and 50 %");
}

TEST_F(RunVerb, StepIsForMethodsWithFixedSteps) {
  EXPECT_EQ(stages_done(path("scan.mhd") + words() + " --keep-paths --method rk4 --step 1e-3"), all);
  const auto record = json::parse(read_input_file(path("out/s/run.json")).value());
  EXPECT_EQ(record["settings"]["step"], 1e-3);
  const auto& certificate = record["stages"][3]["certificate"];
  EXPECT_TRUE(certificate["trusted"].get<bool>());
  // a leap of 0.1 s is 100 steps; a step is cut in two at an output row that is no multiple of the step and
  // where a joint meets or leaves a stop
  const int cuts = static_cast<int>(certificate["events"].size());
  EXPECT_NEAR(certificate["steps_accepted"].get<int>(), 100 + cuts + 3, 3);
  const std::string settings = path("out/s/settings.toml");
  EXPECT_EQ(stages_done("--settings " + settings), Names{});
}

TEST_F(RunVerb, WrongSettingsAreNamedWithTheirLine) {
  for (const auto& [text, said] :
       {std::pair{"[run]\nsex = 'male'\ncolour = 'red'\n", ":3: unknown setting run.colour"},
        {"[run]\n\ntolerance = 'few'\n", ":3: run.tolerance is 'few', expected a number"},
        {"[run]\ntuck = true\n", ":2: run.tuck is true, expected a number"},
        {"[run]\nsubject = 7\n", ":2: run.subject is 7, expected a text in quotes"},
        {"[run]\nallow-untrusted = 'yes'\n", ":2: run.allow-untrusted is 'yes', expected true or false"},
        {"[run]\ntuck = 2\n", ":2: run.tuck: is 2, expected a number from 0 to 1"},
        {"[run]\nsex = 'neither'\n", ":2: run.sex: is 'neither', expected one of male, female"},
        {"[run]\ntuck = [0.5]\n", ":2: run.tuck is a list"},
        {"[run.leap]\ntuck = 1\n", ":1: unknown setting run.leap"},
        {"[walk]\ntuck = 1\n", ":1: unknown verb 'walk'"},
        {"colour = 1\n", ":1: unknown setting colour"},
        {"threads = 1.5\n", ":1: threads is 1.5, expected a whole number"},
        {"[phantom]\nspacing = [2.0, 'x', 3.0]\n", ":2: phantom.spacing is 'x', expected a number"},
        {"[phantom]\nspacing = [2.0, 3.0, 4.0, 5.0]\n", ":2: phantom.spacing has 4 entries"},
        {"[phantom]\nrotation-deg = [1.0, 2.0]\n", ":2: phantom.rotation-deg has 2 entries, expected 3"},
        {"[run]\nhelp = true\n", ":2: unknown setting run.help"},
        {"[run]\ntuck = \n", ":2: "}}) {
    folder.write("run.toml", text);
    expect_refused("run " + path("scan.mhd") + words() + " --settings " + path("run.toml"), 2,
                   path("run.toml") + said);
    EXPECT_FALSE(fs::exists(folder / "out")) << text;
  }
}

TEST_F(RunVerb, RefusesBadUseBeforeAnyWork) {
  fs::create_directories(folder / "slices");             // the next run would read results in there as slices
  for (const char* out : {".", "slices", "slices/new"})  // ".": results go to a folder named as the scan's
    expect_refused("run --keep-paths " + path("slices") + " -o " + path(out), 2,
                   "lies within the scan's folder");
  fs::remove(folder / "slices");
  expect_refused("run " + path("none.mhd") + words(), 2, "none.mhd: no such file");
  expect_refused("run " + path("scan.mhd") + words("s", "none.json"), 2, "none.json: no such file");
  expect_refused("run " + path("scan.mhd") + words() + " --density-curve mine", 2, "schneider2000");
  expect_refused("run " + path("scan.mhd") + words() + " --method rk4 --tolerance 1e-6", 2,
                 "--tolerance: has no effect with rk4");
  expect_refused("run " + path("scan.mhd") + words() + " --step 1e-3", 2, "--step requires --method");
  expect_refused("run " + path("scan.mhd") + words() + " --accuracy 1e-7 --method rk4", 2, "--accuracy");
  const std::string keep = "run " + path("scan.mhd") + words() + " --model-tolerance 5% --keep ";
  expect_refused(keep + "turn:nosuch", 2, "quantity 'turn:nosuch': the scene has no solid of that name");
  expect_refused(keep + "coordinate:spine", 2, "no moving coordinate of that name");
  expect_refused(keep + "solid:head:1,2", 2, "its point must be three numbers");
  expect_refused("run " + path("scan.mhd") +
                     " --quantity hu --segments trunk,leg_left --model-tolerance 5% --keep solid:head -o " +
                     path("out"),
                 2, "quantity 'solid:head': the scene has no solid of that name");
  EXPECT_FALSE(fs::exists(folder / "out"));
  fs::create_directories(result("report.html"));  // blocks the last output
  expect_refused("run " + path("scan.mhd") + words(), 2, "report.html: is a folder");
  fs::remove(result("report.html"));
  std::ofstream(result("mesh")) << "";
  expect_refused("run " + path("scan.mhd") + words(), 1, "mesh is not a folder");
  for (const char* name : {"segmentation", "inertia", "motion", "run.json"})
    EXPECT_FALSE(fs::exists(result(name)));
}

}  // namespace
}  // namespace borelli::run_verb_test
