// Shares work among threads: slices of a volume, members of an ensemble.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <future>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace borelli {

/// The number of threads that `threads` = 0 stands for: as many as the machine has, unless the program sets
/// another number at its start.
inline int all_threads = int(std::max(1U, std::thread::hardware_concurrency()));

/// Runs work(first, last) on disjoint ranges that make up [0, count), one range per thread. `threads` 0:
/// all_threads. Once all ranges have ended, rethrows the first exception that `work` threw.
template <class Work>
void in_slabs(std::int64_t count, int threads, const Work& work) {
  const std::int64_t wanted = threads > 0 ? threads : all_threads;
  const std::int64_t n = std::clamp<std::int64_t>(wanted, 1, std::max<std::int64_t>(count, 1));
  std::exception_ptr thrown;
  std::mutex mutex;
  const auto work_on = [&](std::int64_t t) {
    try {
      work(count * t / n, count * (t + 1) / n);
    } catch (...) {  // must not leave a thread
      const std::lock_guard lock(mutex);
      if (!thrown) thrown = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> team;  // joined at the end of this block
    std::int64_t started = 1;
    try {
      for (; started < n; ++started) team.emplace_back([&, started] { work_on(started); });
    } catch (const std::system_error&) {  // no more threads available: this thread does the rest
    }
    work_on(0);
    for (; started < n; ++started) work_on(started);
  }
  if (thrown) std::rethrow_exception(thrown);
}

/// Like in_slabs, with up to 64 ranges: each thread takes the next free one. For ranges of unequal duration.
template <class Work>
void in_turns(std::int64_t count, int threads, const Work& work) {
  const std::int64_t ranges = std::clamp<std::int64_t>(count, 1, 64);
  std::atomic<std::int64_t> next = 0;
  const std::int64_t wanted = threads > 0 ? threads : all_threads;
  in_slabs(std::min(wanted, ranges), threads, [&](std::int64_t, std::int64_t) {
    for (std::int64_t n = next++; n < ranges; n = next++) work(count * n / ranges, count * (n + 1) / ranges);
  });
}

/// Launch policy of std::async for side work, given the number of `threads` in use. More than one: a new
/// thread if one is available, else deferred until it is waited for. One: always deferred.
inline std::launch aside(int threads) {
  return (threads > 0 ? threads : all_threads) == 1 ? std::launch::deferred
                                                    : std::launch::async | std::launch::deferred;
}

}  // namespace borelli
