#include "dynamics/formats/unique_names.hpp"

#include <gtest/gtest.h>

namespace borelli::test {
namespace {

TEST(UniqueNames, DifferFromAllBefore) {
  UniqueNames names;
  EXPECT_TRUE(names.take("b''"));  // given by a file
  EXPECT_FALSE(names.take("b''"));
  EXPECT_EQ(names.make("b"), "b");
  EXPECT_EQ(names.make("b"), "b'");
  EXPECT_EQ(names.make("b"), "b'''");
  EXPECT_EQ(names.make("b'"), "b''''");
  std::set<std::string> made;
  for (int n = 0; n < 3000; ++n) made.insert(names.make("c"));
  EXPECT_EQ(made.size(), 3000u);
  EXPECT_TRUE(made.contains("c'''''''''"));
  EXPECT_TRUE(made.contains("c'2999"));  // not 2999 primes
}

}  // namespace
}  // namespace borelli::test
