#include "process/child.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

namespace borelli {
namespace {

// Runs `work` in a child process, within 20 s and 256 MiB, and returns its result.
Result<void> tried(const std::function<Result<void>()>& work, double seconds = 20) {
  return in_child("a file", "unpacking it", {.seconds = seconds, .bytes = std::uint64_t{256} << 20}, work);
}

std::string words(const Result<void>& answer) { return answer ? "done" : answer.error().message(); }

TEST(Child, SharesOnlyItsBytes) {
  auto shared = SharedBytes::make("a file", 5);
  ASSERT_TRUE(shared);
  int own = 1;
  const auto answer = tried([&]() -> Result<void> {
    own = 2;
    for (auto& byte : shared->bytes()) byte = std::byte{7};
    return {};
  });
  EXPECT_EQ(words(answer), "done");
  EXPECT_EQ(own, 1);
  for (const auto byte : shared->bytes()) EXPECT_EQ(byte, std::byte{7});
}

TEST(Child, PassesErrorsOn) {
  const auto use = tried([] { return Result<void>(bad_use("place", "wrong")); });
  ASSERT_FALSE(use);
  EXPECT_EQ(use.error().kind, Error::Kind::use);
  EXPECT_EQ(words(use), "place: wrong");
  const auto failed = tried([] { return Result<void>(failure("", std::string(100000, 'x'))); });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().kind, Error::Kind::failure);
  EXPECT_EQ(failed.error().what.size(), 100000U);
}

TEST(Child, NamesItsEnd) {
  EXPECT_EQ(words(tried([]() -> Result<void> {
              raise(SIGSEGV);
              return {};
            })),
            "a file: unpacking it crashed (segmentation fault)");
  EXPECT_EQ(words(tried([]() -> Result<void> { std::abort(); })), "a file: unpacking it crashed (abort)");
  EXPECT_EQ(words(tried([]() -> Result<void> { throw std::runtime_error("[library.42] its own words"); })),
            "a file: unpacking it failed");
}

TEST(Child, IsEndedAtItsTimeLimit) {
  const auto start = std::chrono::steady_clock::now();
  const auto answer = tried(
      []() -> Result<void> {
        for (;;) pause();
      },
      0.2);
  EXPECT_EQ(words(answer), "a file: unpacking it took more than 0.2 s");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(Child, IsEndedAtItsProcessorTimeLimit) {
  ChildLimits limits{.seconds = 20, .processor_seconds = 0.2};
  EXPECT_EQ(words(in_child("a file", "unpacking it", limits,
                           []() -> Result<void> {
                             for (volatile int n = 0;;) n = n + 1;
                           })),
            "a file: unpacking it took more than 0.2 s");
  EXPECT_EQ(words(in_child("a file", "unpacking it", limits,
                           []() -> Result<void> {
                             std::this_thread::sleep_for(std::chrono::milliseconds(400));
                             return {};
                           })),
            "done");
}

TEST(Child, IsRefusedMemoryBeyondItsLimit) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's shadow memory leaves no room for a limit";
#endif
  const auto answer = tried([]() -> Result<void> {
    std::vector<char> much(std::size_t{1} << 30, 'x');
    return much[1000] == 'x' ? Result<void>{} : failure("", "");
  });
  EXPECT_EQ(words(answer), "a file: unpacking it took more than 256 MiB of memory");
}

// The JPEG 2000 codec starts one thread per processor. Their stacks must not count against the memory limit.
TEST(Child, MayStartAThreadForEachProcessor) {
  const long processors = sysconf(_SC_NPROCESSORS_CONF);
  const auto work = [&]() -> Result<void> {
    std::latch all(processors);
    std::vector<std::thread> threads;
    for (long i = 0; i < processors; ++i)
      threads.emplace_back([&] {
        const std::vector<char> some(1000, 'x');
        all.arrive_and_wait();
      });
    for (std::thread& thread : threads) thread.join();
    return {};
  };
  EXPECT_EQ(
      words(in_child("a file", "unpacking it", {.seconds = 20, .bytes = std::uint64_t{16} << 20}, work)),
      "done");
}

TEST(Child, WorksFromAnyThread) {
  std::vector<std::string> answers(4);
  {
    std::vector<std::jthread> team;
    for (auto& answer : answers)
      team.emplace_back([&answer] {
        for (int n = 0; n < 20; ++n)
          answer = words(tried([n] { return Result<void>(failure("", std::to_string(n))); }));
      });
  }
  for (const auto& answer : answers) EXPECT_EQ(answer, "19");
}

}  // namespace
}  // namespace borelli
