// Broken texts for every reader of JSON and TOML: one sentence with file and position, without a library's
// own message, and quickly.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "dynamics/formats/scene_file.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "pipeline/charts/scene_number.hpp"
#include "segmentation/files/class_mapping.hpp"
#include "segmentation/files/given_landmarks.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "tests/paths.hpp"
#include "tests/pipeline/program_run.hpp"

namespace borelli::test::broken_text_test {
namespace {

std::string repeated(const std::string& text, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += text;
  return out;
}

// Errors of all JSON readers for one text.
std::vector<std::string> said_of_json(const std::string& text) {
  const TestFolder folder;
  const std::string file = folder.write("f.json", text);
  std::vector<std::string> said;
  const auto add = [&](const auto& read) { said.push_back(read ? "" : read.error().message()); };
  add(read_landmarks(file));
  add(read_given_landmarks(file));
  add(class_mapping(file));
  add(read_findings(file));
  add(read_table(file));
  const ProgramRun state =
      run_program("evaluate " + source_folder() + "/samples/pendulum.toml --state " + file);
  EXPECT_EQ(state.code, 2);
  said.push_back(state.err);
  return said;
}

TEST(BrokenText, EveryJsonReaderNamesFileAndPlace) {
  for (const auto& [text, place] : std::initializer_list<std::pair<std::string, std::string>>{
           {"{\"a\":\n [1, 2", "f.json:2: is not JSON: it ends too early"},
           {"{\"a\":\n 1e999}", "f.json:2: the number 1e999 is too large"},
           {repeated("[", 1'000'000), "f.json: lists and objects are nested deeper than 100"},
           {"{\"a\": " + repeated("{\"a\": ", 200'000),
            "f.json: lists and objects are nested deeper than 100"}})
    for (const std::string& said : said_of_json(text)) {
      EXPECT_NE(said.find(place), std::string::npos) << said;
      EXPECT_EQ(said.find("exception"), std::string::npos) << said;
    }
}

TEST(BrokenText, EveryTomlReaderRefusesDeepNesting) {
  const TestFolder folder;
  for (const std::string& text :
       {"x = 1\n" + repeated("a.", 100'000) + "a = 1", "x = 1\n[" + repeated("a.", 100'000) + "a]",
        "x = 1\na = " + repeated("[", 100'000)}) {
    const std::string file = folder.write("f.toml", text),
                      place = "f.toml:2: tables and lists are nested deeper than 100";
    std::vector<std::string> said;
    said.push_back(read_scene(file).error().message());
    said.push_back(number_at(text, file, "x").error().message());
    said.push_back(with_number(text, file, "x", 1).error().message());
    for (const std::string& command : {"info " + file, "--settings " + file + " info " + file}) {
      const ProgramRun run = run_program(command);
      EXPECT_EQ(run.code, 2) << command;
      said.push_back(run.err);
    }
    for (const std::string& one : said) EXPECT_NE(one.find(place), std::string::npos) << one;
  }
}

// Findings whose values have other types than `borelli segment` writes.
TEST(BrokenText, NamesFindingsOfAWrongType) {
  const TestFolder folder;
  for (const auto& [text, what] : std::initializer_list<std::pair<const char*, const char*>>{
           {R"({"parts": {"head": {"coverage": 3}}})",
            "f.json: head: coverage is the number 3, expected a text"},
           {R"({"parts": {"head": {"coverage": "whole", "volume_mm3": "x"}}})",
            "f.json: head: volume_mm3 is the text \"x\", expected a number"},
           {R"({"parts": {"head": 1}})", "f.json: head: has no \"coverage\""},
           {R"({"parts": []})", "is not a record of a segmentation"}}) {
    const auto read = read_findings(folder.write("f.json", text));
    ASSERT_FALSE(read) << text;
    EXPECT_NE(read.error().message().find(what), std::string::npos) << read.error().message();
  }
}

TEST(BrokenText, TooLongPathsAreRefusedInOneSentence) {
  const std::string far = "/" + repeated("long", 2000);
  for (const std::string verb :
       {"info ", "report ", "simulate ", "economy ", "skeleton --landmarks x -o x.toml "}) {
    const ProgramRun run = run_program(verb + far);
    EXPECT_NE(run.code, 0) << verb;
    for (const char* words : {"filesystem error", "std::", "exception"})
      EXPECT_EQ(run.err.find(words), std::string::npos) << verb << run.err.substr(0, 200);
  }
}

}  // namespace
}  // namespace borelli::test::broken_text_test
