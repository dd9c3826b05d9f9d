#include "pipeline/stages/stages.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <thread>

#include "pipeline/files/digest.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Stages : testing::Test {
  fs::path folder = fs::path(testing::TempDir()) / ("stages_test_" + std::to_string(::getpid()));
  std::vector<std::string> ran;
  json first_settings = {{"step", 3}};
  std::string broken;
  std::vector<EditableOutput> editable;  // editable outputs of the stages

  void SetUp() override { fs::remove_all(folder), fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  Stage stage(const std::string& name, std::vector<std::string> needs, json settings) {
    std::vector<EditableOutput> of_this;
    for (const EditableOutput& output : editable)
      if (output.file == name + ".txt") of_this.push_back(output);
    return {name,
            std::move(needs),
            std::move(settings),
            {name + ".txt"},
            [this, name](const StageProgress&, const json&) -> Result<json> {
              if (name == broken) return failure(name, "broken");
              ran.push_back(name);
              if (auto written = write_whole(folder / (name + ".txt"), name); !written)
                return tl::unexpected(written.error());
              return json{{"warnings", {name + " says so"}}};
            },
            of_this};
  }
  void edit(const std::string& file, const std::string& text) { std::ofstream(folder / file) << text; }
  std::string text(const std::string& file) const { return read_input_file(folder / file).value(); }
  using Names = std::vector<std::string>;

  Result<json> run(bool force = false, const std::string& input = "abc") {
    ran.clear();
    const auto lock = FolderLock::take(folder);
    if (!lock) return tl::unexpected(lock.error());
    return run_stages(*lock, {{"inputs", input}},
                      {stage("one", {}, first_settings), stage("two", {"one"}, {}), stage("aside", {}, {})},
                      force, 1);
  }
};

TEST_F(Stages, NamesFilesThatOnlyEarlierRunsWrote) {
  const std::string left = "left_by_earlier_runs";
  std::vector<std::string> heard;
  StageObserver observer;
  observer.warns = [&](const Stage& of, const std::string& warning) {
    if (warning.starts_with("an earlier run")) heard.push_back(of.name + ": " + warning);
  };
  const auto without_aside = [&](bool force) {
    return run_stages(*FolderLock::take(folder), {{"inputs", "abc"}},
                      {stage("one", {}, first_settings), stage("two", {"one"}, {})}, force, 1, observer);
  };
  EXPECT_FALSE(run()->contains(left));
  for (const bool force : {false, true, false})  // again and again, until they are gone
    EXPECT_EQ(without_aside(force).value().at(left), json({"aside.txt"})) << force;
  EXPECT_EQ(
      heard,
      Names(3, "two: an earlier run with other settings wrote aside.txt; this run did not, and keeps it"));
  EXPECT_EQ(text("aside.txt"), "aside");
  broken = "two";  // a run that stops remembers them
  EXPECT_FALSE(without_aside(true));
  broken = "";
  EXPECT_EQ(without_aside(false).value().at(left), json({"aside.txt"}));
  fs::remove(folder / "aside.txt");
  EXPECT_FALSE(without_aside(false)->contains(left));
  EXPECT_FALSE(run()->contains(left));
}

// A first stage, two that need it, "left" and "right", which may run in parallel, and one that needs both.
struct StagesSideBySide : testing::Test {
  fs::path folder = fs::path(testing::TempDir()) / ("stages_side_test_" + std::to_string(::getpid()));
  std::mutex mutex;
  std::vector<std::string> ran;
  std::map<std::string, std::function<void()>> first;  // work of a stage before it writes its file
  std::map<std::string, std::string> broken;
  std::string endless;  // this stage runs until it is stopped
  StageObserver observer;

  void SetUp() override { fs::remove_all(folder), fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  Stage stage(const std::string& name, std::vector<std::string> needs) {
    return {name,
            std::move(needs),
            {},
            {name + ".txt"},
            [this, name](const StageProgress& progress, const json& record) -> Result<json> {
              if (first.contains(name)) first.at(name)();
              if (broken.contains(name)) return failure(name, broken.at(name));
              for (int i = 0; i < 100; ++i) progress(0.01 * i);
              for (int i = 0; i < 5000 && name == endless; ++i) {
                if (!progress(0.99)) return failure(name, "stopped");
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
              }
              {
                const std::lock_guard lock(mutex);
                ran.push_back(name);
              }
              if (auto written = write_whole(folder / (name + ".txt"), name); !written)
                return tl::unexpected(written.error());
              json seen = json::array();
              for (const json& entry : record["stages"]) seen.push_back(entry["stage"]);
              return json{{"seen", seen}};
            }};
  }

  Result<json> run(int threads) {
    ran.clear();
    const auto lock = FolderLock::take(folder);
    if (!lock) return tl::unexpected(lock.error());
    return run_stages(*lock, {{"inputs", "abc"}},
                      {stage("one", {}), stage("left", {"one"}), stage("lefter", {"left"}),
                       stage("right", {"one"}), stage("all", {"lefter", "right"})},
                      false, threads, observer);
  }
  json record() const { return json::parse(read_input_file(folder / "run.json").value()); }

  static std::vector<std::string> names(const json& record) {
    std::vector<std::string> names;
    for (const json& entry : record["stages"]) names.push_back(entry["stage"]);
    return names;
  }
  static void wait_for(const std::atomic<bool>& flag) {
    for (int i = 0; i < 5000 && !flag; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(flag) << "within five seconds";
  }
};

TEST_F(StagesSideBySide, IndependentStagesRunInParallel) {
  std::atomic<bool> left = false, right = false;
  first["left"] = [&] { left = true, wait_for(right); };
  first["right"] = [&] { right = true, wait_for(left); };
  const auto record = run(2);
  ASSERT_TRUE(record);
  EXPECT_EQ(ran.front(), "one");
  EXPECT_EQ(ran.back(), "all");
  EXPECT_EQ((*record)["stages"].back()["seen"], json({"one", "left", "lefter", "right"}));
}

TEST_F(StagesSideBySide, RecordKeepsTheOrderOfOneThread) {
  const auto without_times = [](json record) {
    for (json& entry : record["stages"])
      for (const char* name : {"seconds", "peak_memory_mib", "seen"}) entry.erase(name);
    record.erase("slowest");
    return record;
  };
  ASSERT_TRUE(run(1));
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "left", "lefter", "right", "all"}));
  const json in_turn = record();
  fs::remove_all(folder);
  std::atomic<bool> right = false;
  first["left"] = [&] { wait_for(right); };
  observer.ends = [&](const Stage& stage, double) { right = right || stage.name == "right"; };
  ASSERT_TRUE(run(2));
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "right", "left", "lefter", "all"}));
  EXPECT_EQ(without_times(record()), without_times(in_turn));
  ASSERT_TRUE(run(2));
  EXPECT_TRUE(ran.empty());
}

TEST_F(StagesSideBySide, FirstFailureIsNamedAndLaterStagesDoNotStart) {
  std::atomic<bool> left = false, right = false;
  broken = {{"lefter", "broken"}, {"right", "broken, too"}};
  first["left"] = [&] { left = true, wait_for(right); };  // the later stage fails first
  first["right"] = [&] { wait_for(left), right = true; };
  for (const int threads : {2, 1}) {
    const auto stopped = run(threads);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().where, "lefter");
    EXPECT_EQ(stopped.error().what, "broken");
    EXPECT_FALSE(fs::exists(folder / "all.txt"));
  }
}

TEST_F(StagesSideBySide, KeepsParallelResultsOfAFailedRun) {
  std::atomic<bool> right = false;
  broken = {{"left", "broken"}};
  first["left"] = [&] { wait_for(right); };
  first["right"] = [&] { right = true; };
  ASSERT_FALSE(run(2));
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "right"}));
  EXPECT_EQ(names(record()), (std::vector<std::string>{"one", "right"}));
  broken.clear();
  const auto whole = run(2);
  ASSERT_TRUE(whole);
  EXPECT_EQ(ran, (std::vector<std::string>{"left", "lefter", "all"}));
  EXPECT_EQ(names(*whole), (std::vector<std::string>{"one", "left", "lefter", "right", "all"}));
}

TEST_F(StagesSideBySide, FailureIsReportedAtOnceAndStopsLaterStages) {
  broken = {{"left", "broken"}};
  endless = "right";
  std::atomic<bool> right = false;
  std::vector<std::string> told;
  observer.begins = [&](const Stage& stage) { right = right || stage.name == "right"; };
  observer.fails = [&](const Stage& stage, const Error& error) {
    told.push_back(stage.name + " " + error.what);
  };
  first["left"] = [&] { wait_for(right); };
  const auto stopped = run(2);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().where, "left");
  EXPECT_EQ(told, (std::vector<std::string>{"left broken"}));
  EXPECT_EQ(ran, (std::vector<std::string>{"one"}));
  EXPECT_EQ(names(record()), (std::vector<std::string>{"one"}));
  std::set<std::string> left_there;
  for (const auto& entry : fs::directory_iterator(folder)) left_there.insert(entry.path().filename());
  EXPECT_EQ(left_there, (std::set<std::string>{".lock", "one.txt", "run.json"}));
  broken.clear(), endless.clear();
  const auto whole = run(1);
  ASSERT_TRUE(whole);
  EXPECT_EQ(ran, (std::vector<std::string>{"left", "lefter", "right", "all"}));
}

TEST_F(StagesSideBySide, FailureIsReportedWhileEarlierStagesContinue) {
  broken = {{"right", "broken"}};
  std::atomic<bool> left = false, told = false;
  observer.fails = [&](const Stage& stage, const Error&) { told = stage.name == "right"; };
  first["left"] = [&] { left = true, wait_for(told); };
  first["right"] = [&] { wait_for(left); };
  const auto stopped = run(2);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().where, "right");
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "left", "lefter"}));
}

TEST_F(StagesSideBySide, OrderedStagesWaitForEachOther) {
  const auto lock = FolderLock::take(folder);
  ASSERT_TRUE(lock);
  std::vector<Stage> stages{stage("one", {}), stage("two", {}), stage("three", {})};
  stages[2].after = {"one", "two"};
  first["three"] = [&] { EXPECT_EQ(ran.size(), 2u); };
  const auto record = run_stages(*lock, {{"inputs", "abc"}}, stages, false, 3, observer);
  ASSERT_TRUE(record);
  EXPECT_EQ(ran.back(), "three");
}

TEST_F(StagesSideBySide, OutOfMemoryInAStageEndsTheRun) {
  for (const char* name : {"left", "right"}) {
    fs::remove_all(folder);
    first = {{name, [] { throw std::bad_alloc(); }}};
    EXPECT_THROW(static_cast<void>(run(2)), std::bad_alloc) << name;
    EXPECT_FALSE(fs::exists(folder / "all.txt"));
  }
}

TEST_F(StagesSideBySide, ObserverCallsDoNotOverlap) {
  std::atomic<int> telling = 0;
  std::map<std::string, int> told;
  const auto tell = [&](const Stage& stage) {
    EXPECT_EQ(++telling, 1);
    ++told[stage.name];
    --telling;
  };
  observer = {tell, [&](const Stage& stage, double) { tell(stage); },
              [&](const Stage& stage, double) { tell(stage); }, tell};
  ASSERT_TRUE(run(0));
  EXPECT_EQ(told, (std::map<std::string, int>{
                      {"one", 102}, {"left", 102}, {"lefter", 102}, {"right", 102}, {"all", 102}}));
}

TEST_F(Stages, SecondRunRepeatsNothing) {
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "two", "aside"}));
  const auto record = run();
  ASSERT_TRUE(record);
  EXPECT_TRUE(ran.empty());
  EXPECT_EQ((*record)["stages"].size(), 3u);
  EXPECT_EQ(json::parse(read_input_file(folder / "run.json").value()), *record);
}

TEST_F(Stages, NamesTheThreeSlowestStages) {
  ASSERT_TRUE(run());
  json record = json::parse(read_input_file(folder / "run.json").value());
  const std::map<std::string, double> seconds{{"one", 1}, {"two", 6}, {"aside", 3}};
  for (json& stage : record["stages"]) stage["seconds"] = seconds.at(stage["stage"]);
  edit("run.json", record.dump());
  const auto again = run();
  ASSERT_TRUE(again);
  EXPECT_EQ((*again)["slowest"], json::parse(R"([{"stage": "two", "seconds": 6.0, "share": 0.6},
                                                 {"stage": "aside", "seconds": 3.0, "share": 0.3},
                                                 {"stage": "one", "seconds": 1.0, "share": 0.1}])"));
}

TEST_F(Stages, ChangeRepeatsOnlyDependentStages) {
  ASSERT_TRUE(run());
  first_settings["step"] = 2;
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "two"}));
  ASSERT_TRUE(run(false, "another input"));
  EXPECT_EQ(ran.size(), 3u);
  ASSERT_TRUE(run(true, "another input"));
  EXPECT_EQ(ran.size(), 3u);
}

TEST_F(Stages, StoppedRunContinuesAtTheFirstUnfinishedStage) {
  broken = "two";
  const auto stopped = run();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().what, "broken");
  broken.clear();
  const pid_t ended = fork();
  if (ended == 0) _exit(0);
  waitpid(ended, nullptr, 0);
  const fs::path partial = folder / (".partial-" + std::to_string(ended) + "-two.txt");
  std::ofstream(partial) << "half";
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"two", "aside"}));
  EXPECT_FALSE(fs::exists(partial));
}

TEST_F(Stages, MissingOutputIsWrittenAgain) {
  ASSERT_TRUE(run());
  fs::remove(folder / "two.txt");
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"two"}));
}

TEST_F(Stages, EmptiedOrCutOutputIsWrittenAgain) {
  ASSERT_TRUE(run());
  fs::resize_file(folder / "one.txt", 2);
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"one"}));
  EXPECT_EQ(read_input_file(folder / "one.txt").value(), "one");
}

TEST_F(Stages, ChangedOutputOfEqualSizeIsWrittenAgain) {
  ASSERT_TRUE(run());
  edit("two.txt", "twp");
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, Names{"two"});
  EXPECT_EQ(text("two.txt"), "two");
  // a record of an earlier version has no digests
  json record = json::parse(text("run.json"));
  record["stages"][0].erase("digests");
  edit("run.json", record.dump());
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, Names{"one"});
}

TEST_F(Stages, FileChangedByHandIsKeptAndUsed) {
  editable = {{"one.txt"}};
  ASSERT_TRUE(run());
  edit("one.txt", "One");  // same length
  const std::string kept = "one.txt was changed by hand and is kept; --force writes it again";
  for (const Names& done : {Names{"two"}, Names{}}) {
    const auto record = run();
    ASSERT_TRUE(record);
    EXPECT_EQ(ran, done);
    EXPECT_EQ((*record)["stages"][0]["warnings"], json({"one says so", kept}));
  }
  edit("one.txt", "One and more");
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, Names{"two"});

  first_settings["step"] = 2;
  const auto other = run();
  ASSERT_TRUE(other);
  EXPECT_EQ(ran, Names{"two"});
  EXPECT_EQ(text("one.txt"), "One and more");
  EXPECT_NE((*other)["stages"][0]["warnings"][1].get<std::string>().find("settings or inputs"),
            std::string::npos);
  first_settings["step"] = 3;

  edit("one.txt", "one");  // as the stage wrote it
  const auto back = run();
  ASSERT_TRUE(back);
  EXPECT_EQ(ran, Names{"two"});
  EXPECT_EQ((*back)["stages"][0]["warnings"], json({"one says so"}));

  edit("one.txt", "One");
  ASSERT_TRUE(run(true));
  EXPECT_EQ(ran.size(), 3u);
  EXPECT_EQ(text("one.txt"), "one");
}

TEST_F(Stages, ChangedFileThatNothingReadsIsKeptWithAWarning) {
  editable = {{"one.txt", "another.txt"}};
  ASSERT_TRUE(run());
  edit("one.txt", "ONE");
  const auto record = run();
  ASSERT_TRUE(record);
  EXPECT_EQ(ran, Names{});
  EXPECT_EQ((*record)["stages"][0]["warnings"][1],
            "one.txt was changed by hand and is kept, although later stages read another.txt; --force writes "
            "it again");
}

TEST_F(Stages, StoppedRunRemembersFilesChangedByHand) {
  editable = {{"aside.txt"}};
  ASSERT_TRUE(run());
  edit("aside.txt", "ASIDE");
  first_settings["step"] = 2;
  broken = "two";  // run.json is already written, but the stage 'aside' has not begun
  ASSERT_FALSE(run());
  EXPECT_EQ(ran, Names{"one"});
  broken.clear();
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, Names{"two"});
  EXPECT_EQ(text("aside.txt"), "ASIDE");
}

TEST_F(Stages, FolderInPlaceOfAnOutputIsRefusedBeforeAnyStage) {
  fs::create_directories(folder / "aside.txt");
  const auto answer = run();
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().where, folder / "aside.txt");
  EXPECT_TRUE(ran.empty());
}

TEST_F(Stages, FolderIsLockedByOneRun) {
  {
    const auto lock = FolderLock::take(folder / "deep");
    ASSERT_TRUE(lock);
    const auto second = FolderLock::take(folder / "deep");
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().what.find("another run is using this folder"), std::string::npos);
  }
  EXPECT_TRUE(FolderLock::take(folder / "deep"));
  std::ofstream(folder / "file") << "";
  EXPECT_FALSE(FolderLock::take(folder / "file" / "below"));
}

TEST_F(Stages, DamagedRecordIsNamed) {
  std::ofstream(folder / "run.json") << "{\"stages\": [";
  const auto answer = run();
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message().find("run.json"), std::string::npos);
  EXPECT_TRUE(run(true));
}

TEST(Digest, EqualsSha256) {
  // FIPS 180-2, appendix B.1
  EXPECT_EQ(digest_of_bytes("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace borelli
