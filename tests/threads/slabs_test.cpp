#include "threads/slabs.hpp"

#include <gtest/gtest.h>

#include <new>

namespace borelli {
namespace {

TEST(Slabs, WhatOneThrowsReachesTheCallerOnceAllHaveEnded) {
  for (const int threads : {1, 2}) {
    std::atomic<int> ended = 0;
    EXPECT_THROW(in_slabs(2, threads,
                          [&](std::int64_t first, std::int64_t last) {
                            ++ended;
                            EXPECT_LT(first, last);
                            if (last == 2) throw std::bad_alloc();
                          }),
                 std::bad_alloc);
    EXPECT_EQ(ended, threads);
  }
}

}  // namespace
}  // namespace borelli
