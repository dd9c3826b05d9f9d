#include "error/printable.hpp"

#include <gtest/gtest.h>

namespace borelli {
namespace {

TEST(Printable, ShowsOtherBytesAsHexAndShortensLongTexts) {
  EXPECT_EQ(printable("MET_SHORT"), "MET_SHORT");
  EXPECT_EQ(printable(std::string("a\n\x01\xff", 4)), "a<0a><01><ff>");
  EXPECT_EQ(printable(std::string(41, 'x')), std::string(40, 'x') + "...");
  EXPECT_EQ(printable(std::string(41, 'x'), 41), std::string(41, 'x'));
}

TEST(NameList, ListsTheFirstNamesAndCountsTheRest) {
  EXPECT_EQ(name_list({}), "");
  EXPECT_EQ(name_list({"a", "b", "c"}, 3), "a, b, c");
  EXPECT_EQ(name_list({"a", "b", "c", "d", "e"}, 3), "a, b, c and 2 more");
}

}  // namespace
}  // namespace borelli
