#include "pipeline/stages.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <map>

#include "pipeline/whole_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Stages : testing::Test {
  fs::path folder = fs::path(testing::TempDir()) / ("stages_test_" + std::to_string(::getpid()));
  std::vector<std::string> ran;
  json first_settings = {{"step", 3}};
  std::string broken;
  std::vector<EditableOutput> editable;  // of the stages that leave them

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
            [this, name](const Progress&, const json&) -> Result<json> {
              if (name == broken) return failure(name, "broken");
              ran.push_back(name);
              if (auto written = write_whole(folder / (name + ".txt"), name); !written)
                return tl::unexpected(written.error());
              return json{{"warnings", {name + " says so"}}};
            },
            of_this};
  }
  void edit(const std::string& file, const std::string& text) { std::ofstream(folder / file) << text; }
  std::string text(const std::string& file) const { return read_whole(folder / file).value(); }
  using Names = std::vector<std::string>;

  Result<json> run(bool force = false, const std::string& input = "abc") {
    ran.clear();
    const auto lock = FolderLock::take(folder);
    if (!lock) return tl::unexpected(lock.error());
    return run_stages(*lock, {{"inputs", input}},
                      {stage("one", {}, first_settings), stage("two", {"one"}, {}), stage("aside", {}, {})},
                      force);
  }
};

TEST_F(Stages, SecondRunDoesNothingAgain) {
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "two", "aside"}));
  const auto record = run();
  ASSERT_TRUE(record);
  EXPECT_TRUE(ran.empty());
  EXPECT_EQ((*record)["stages"].size(), 3u);
  EXPECT_EQ(json::parse(read_whole(folder / "run.json").value()), *record);
}

TEST_F(Stages, TheSlowestThreeAreNamedWithTheirShare) {
  ASSERT_TRUE(run());
  json record = json::parse(read_whole(folder / "run.json").value());
  const std::map<std::string, double> seconds{{"one", 1}, {"two", 6}, {"aside", 3}};
  for (json& stage : record["stages"]) stage["seconds"] = seconds.at(stage["stage"]);
  edit("run.json", record.dump());
  const auto again = run();
  ASSERT_TRUE(again);
  EXPECT_EQ((*again)["slowest"], json::parse(R"([{"stage": "two", "seconds": 6.0, "share": 0.6},
                                                 {"stage": "aside", "seconds": 3.0, "share": 0.3},
                                                 {"stage": "one", "seconds": 1.0, "share": 0.1}])"));
}

TEST_F(Stages, ChangeRerunsWhatDependsOnItAndNothingElse) {
  ASSERT_TRUE(run());
  first_settings["step"] = 2;
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"one", "two"}));
  ASSERT_TRUE(run(false, "another input"));
  EXPECT_EQ(ran.size(), 3u);
  ASSERT_TRUE(run(true, "another input"));
  EXPECT_EQ(ran.size(), 3u);
}

TEST_F(Stages, StoppedRunGoesOnAtTheFirstUnfinishedStage) {
  broken = "two";
  const auto stopped = run();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().what, "broken");
  broken.clear();
  std::ofstream(folder / ".partial-1-two.txt") << "half";
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"two", "aside"}));
  EXPECT_FALSE(fs::exists(folder / ".partial-1-two.txt"));
}

TEST_F(Stages, MissingOutputIsMadeAgain) {
  ASSERT_TRUE(run());
  fs::remove(folder / "two.txt");
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"two"}));
}

TEST_F(Stages, EmptiedOrCutOutputIsMadeAgain) {
  ASSERT_TRUE(run());
  fs::resize_file(folder / "one.txt", 2);
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, (std::vector<std::string>{"one"}));
  EXPECT_EQ(read_whole(folder / "one.txt").value(), "one");
}

TEST_F(Stages, AFileChangedByHandStaysAndWhatDependsOnItIsDoneAgain) {
  editable = {{"one.txt"}};
  ASSERT_TRUE(run());
  edit("one.txt", "One");  // as long as it was
  const std::string kept = "one.txt was changed by hand: kept; --force makes it anew";
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

  edit("one.txt", "one");  // as the stage left it
  const auto back = run();
  ASSERT_TRUE(back);
  EXPECT_EQ(ran, Names{"two"});
  EXPECT_EQ((*back)["stages"][0]["warnings"], json({"one says so"}));

  edit("one.txt", "One");
  ASSERT_TRUE(run(true));
  EXPECT_EQ(ran.size(), 3u);
  EXPECT_EQ(text("one.txt"), "one");
}

TEST_F(Stages, AFileThatNothingReadsIsKeptAndSaysWhatIsRead) {
  editable = {{"one.txt", "another.txt"}};
  ASSERT_TRUE(run());
  edit("one.txt", "ONE");
  const auto record = run();
  ASSERT_TRUE(record);
  EXPECT_EQ(ran, Names{});
  EXPECT_EQ(
      (*record)["stages"][0]["warnings"][1],
      "one.txt was changed by hand: kept, though what follows reads another.txt; --force makes it anew");
}

TEST_F(Stages, AStoppedRunForgetsNoFileThatWasChangedByHand) {
  editable = {{"aside.txt"}};
  ASSERT_TRUE(run());
  edit("aside.txt", "ASIDE");
  first_settings["step"] = 2;
  broken = "two";  // run.json has been written by then, before the stage 'aside' was come to
  ASSERT_FALSE(run());
  EXPECT_EQ(ran, Names{"one"});
  broken.clear();
  ASSERT_TRUE(run());
  EXPECT_EQ(ran, Names{"two"});
  EXPECT_EQ(text("aside.txt"), "ASIDE");
}

TEST_F(Stages, OutputInWhosePlaceAFolderIsStopsItBeforeAnyStage) {
  fs::create_directories(folder / "aside.txt");
  const auto answer = run();
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().where, folder / "aside.txt");
  EXPECT_TRUE(ran.empty());
}

TEST_F(Stages, AFolderIsLockedOnceAtATime) {
  {
    const auto lock = FolderLock::take(folder / "deep");
    ASSERT_TRUE(lock);
    const auto second = FolderLock::take(folder / "deep");
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().what.find("another run is at work"), std::string::npos);
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

TEST(Digest, IsSha256) {
  // FIPS 180-2, appendix B.1
  EXPECT_EQ(digest_of_bytes("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace borelli
