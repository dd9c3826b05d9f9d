#include "error/nearest_name.hpp"

#include <gtest/gtest.h>

namespace borelli::nearest_name_test {
namespace {

// distances of the literature: kitten, sitting (Wagner and Fischer's example); Saturday, Sunday
TEST(NearestName, EditDistancesMatchTextbooks) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("Saturday", "Sunday"), 3U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", "abc"), 0U);
}

TEST(NearestName, IsGivenOnlyIfMostLettersAgree) {
  const std::vector<std::string> verbs{"segment", "simulate", "skeleton", "run"};
  EXPECT_EQ(nearest_name("simulat", verbs), "simulate");
  EXPECT_EQ(nearest_name("segemnt", verbs), "segment");
  EXPECT_EQ(nearest_name("rum", verbs), "run");
  EXPECT_EQ(nearest_name("banana", verbs), std::nullopt);
  EXPECT_EQ(nearest_name("x", verbs), std::nullopt);
  EXPECT_EQ(nearest_name("run", {}), std::nullopt);
}

}  // namespace
}  // namespace borelli::nearest_name_test
