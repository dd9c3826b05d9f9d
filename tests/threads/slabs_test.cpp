#include "threads/slabs.hpp"

#include <gtest/gtest.h>

#include <new>
#include <vector>

namespace borelli {
namespace {

TEST(Slabs, ExceptionReachesTheCallerAfterAllHaveEnded) {
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

TEST(Slabs, EachIsProcessedOnce) {
  for (const int threads : {0, 1, 3})
    for (const std::int64_t count : {0, 1, 2, 63, 64, 65, 1000}) {
      std::vector<std::atomic<int>> in_slab(count), in_turn(count);
      const auto into = [](auto& done) {
        return [&](std::int64_t first, std::int64_t last) {
          for (std::int64_t i = first; i < last; ++i) ++done[i];
        };
      };
      in_slabs(count, threads, into(in_slab));
      in_turns(count, threads, into(in_turn));
      for (std::int64_t i = 0; i < count; ++i) {
        EXPECT_EQ(in_slab[i], 1) << i << " of " << count << " by " << threads;
        EXPECT_EQ(in_turn[i], 1) << i << " of " << count << " by " << threads;
      }
    }
}

// The program's `--threads` limits all parallel work, also if a caller requests all threads.
TEST(Slabs, UsesTheRequestedNumberOfThreads) {
  const int before = all_threads;
  for (const int told : {1, 3}) {
    all_threads = told;
    std::mutex mutex;
    std::vector<std::thread::id> callers;
    in_slabs(100, 0, [&](std::int64_t, std::int64_t) {
      const std::lock_guard lock(mutex);
      callers.push_back(std::this_thread::get_id());
    });
    EXPECT_EQ(callers.size(), std::size_t(told));
    EXPECT_EQ(std::ranges::count(callers, std::this_thread::get_id()), 1);
    EXPECT_EQ(aside(0) == std::launch::deferred, told == 1);
  }
  all_threads = before;
}

}  // namespace
}  // namespace borelli
