// The suite of hard cases (tests/suite): each case must miss exactly the demands listed in misses.txt, so
// both losses and gains show. `phantom_suite --misses` writes a new list.
#include "tests/suite/phantom_suite.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/paths.hpp"

namespace borelli {
namespace {

std::vector<std::string> known_misses(const std::string& name) {
  std::vector<std::string> known;
  std::ifstream list(test::source_folder() + "/tests/suite/misses.txt");
  EXPECT_TRUE(list) << "no misses.txt";
  for (std::string line; std::getline(list, line);)
    if (line.starts_with(name + ": ")) known.push_back(line.substr(name.size() + 2));
  return known;
}

class PhantomSuite : public testing::TestWithParam<suite::Case> {};

TEST_P(PhantomSuite, FailsOnlyKnownFailures) {
  const suite::Score score = suite::score(GetParam());
  const std::vector<std::string> known = known_misses(GetParam().name);
  for (const std::string& miss : score.misses)
    EXPECT_NE(std::find(known.begin(), known.end(), miss), known.end()) << "misses now: " << miss;
  for (const std::string& miss : known)
    EXPECT_NE(std::find(score.misses.begin(), score.misses.end(), miss), score.misses.end())
        << "meets now, take it from misses.txt: " << miss;
}

INSTANTIATE_TEST_SUITE_P(Suite, PhantomSuite, testing::ValuesIn(suite::cases()),
                         [](const auto& made) { return made.param.name; });

TEST(PhantomSuiteList, NamesOnlyExistingCases) {
  std::ifstream list(test::source_folder() + "/tests/suite/misses.txt");
  const auto all = suite::cases();
  for (std::string line; std::getline(list, line);)
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const suite::Case& c) {
      return line.starts_with(c.name + ": ");
    })) << line;
}

}  // namespace
}  // namespace borelli
