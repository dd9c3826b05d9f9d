// Runs tests with this processor's register width and with each narrower one.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "dynamics/numbers/processor.hpp"

namespace borelli::test {

/// The parameter is the registers' width, in numbers.
class EachWidth : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override { register_width = GetParam(); }
  void TearDown() override { register_width = widest_; }

 private:
  int widest_ = register_width;
};

inline std::vector<int> all_widths() {
  std::vector<int> out;
  for (int width = 2; width <= register_width; width *= 2) out.push_back(width);
  return out;
}

}  // namespace borelli::test
