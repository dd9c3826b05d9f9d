#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>

#include "segmentation/proposal/class_probabilities.hpp"
#include "tests/paths.hpp"

namespace borelli::proposal_test {
namespace {

std::string forest_file(const std::string& name) {
  std::ifstream file(test::source_folder() + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// rows of features with scikit-learn's predictions, written by train_forest.py
TEST(Forest, EqualsScikitLearn) {
  const auto forest = parse_forest(forest_file("/tests/segmentation/files/forest.bin"), "forest.bin");
  ASSERT_TRUE(forest) << forest.error().message();
  std::istringstream lines(forest_file("/tests/segmentation/files/forest_rows.txt"));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    std::istringstream words(line);
    std::vector<std::int16_t> row(forest->features.size());
    for (auto& value : row) words >> value;
    std::vector<std::uint32_t> sums(forest->classes.size());
    forest->add_up(row, sums);
    for (const std::uint32_t sum : sums) {
      double expected = -1;
      words >> expected;
      ASSERT_NEAR(static_cast<double>(sum) / forest->whole(), expected, 1e-6) << "row " << count;
    }
  }
  EXPECT_GE(count, 100);
}

TEST(Forest, BuiltInForestFitsTheProgram) {
  const auto forest = ready_forest();
  ASSERT_TRUE(forest) << forest.error().message();
  EXPECT_EQ(forest->features, voxel_feature_names());
  EXPECT_TRUE(
      std::equal(forest->classes.begin(), forest->classes.end(), voxel_classes.begin(), voxel_classes.end()));
}

std::string refusal(const std::string& bytes) {
  const auto forest = parse_forest(bytes, "model");
  return forest ? "" : forest.error().message();
}

TEST(Forest, RefusesDamagedFilesInOneSentence) {
  const std::string whole = forest_file("/tests/segmentation/files/forest.bin");
  ASSERT_EQ(refusal(whole), "");
  EXPECT_EQ(refusal(""), "model: is not a forest: it does not begin with 'borelli-forest'");
  std::string other = whole;
  other[other.find('1')] = '2';
  EXPECT_EQ(refusal(other),
            "model: is a forest of another version than 1; train it again with this program's script");
  EXPECT_NE(refusal(whole.substr(0, whole.size() / 2)), "");
  EXPECT_NE(refusal(whole + "x"), "");
  EXPECT_NE(refusal(whole.substr(0, 20)), "");
  // any changed byte is refused, or, within a name, read as another name
  std::mt19937 random(1);
  const std::size_t data = whole.find('\n', whole.find("\nbytes ") + 1) + 1;
  for (int n = 0; n < 200; ++n) {
    std::string damaged = whole;
    damaged[std::uniform_int_distribution<std::size_t>(data, whole.size() - 1)(random)] ^= 0x55;
    const std::string message = refusal(damaged);
    EXPECT_NE(message, "");
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace borelli::proposal_test
