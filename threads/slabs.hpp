// Work shared among threads: slices of a volume, members of an ensemble.
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

/// How many threads 0 stands for: as many as the machine has, unless the program was told another number
/// before anything worked.
inline int all_threads = int(std::max(1U, std::thread::hardware_concurrency()));

/// Runs work(first, last) on disjoint ranges that make up [0, count), one range per thread. `threads` 0:
/// all_threads. What `work` throws first is thrown once all ranges have come to an end.
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
    std::vector<std::jthread> team;  // which ends before this block is left
    std::int64_t started = 1;
    try {
      for (; started < n; ++started) team.emplace_back([&, started] { work_on(started); });
    } catch (const std::system_error&) {  // no more threads can be had: the rest is the caller's
    }
    work_on(0);
    for (; started < n; ++started) work_on(started);
  }
  if (thrown) std::rethrow_exception(thrown);
}

/// The same in more ranges than threads, each of which takes the next one that is left: where some take much
/// longer than others.
template <class Work>
void in_turns(std::int64_t count, int threads, const Work& work) {
  const std::int64_t ranges = std::clamp<std::int64_t>(count, 1, 64);
  std::atomic<std::int64_t> next = 0;
  const std::int64_t wanted = threads > 0 ? threads : all_threads;
  in_slabs(std::min(wanted, ranges), threads, [&](std::int64_t, std::int64_t) {
    for (std::int64_t n = next++; n < ranges; n = next++) work(count * n / ranges, count * (n + 1) / ranges);
  });
}

/// How std::async is to do what may go on aside, where work is shared among as many `threads`: in a thread of
/// its own if there is more than one and another can be had, else when it is waited for.
inline std::launch aside(int threads) {
  return (threads > 0 ? threads : all_threads) == 1 ? std::launch::deferred
                                                    : std::launch::async | std::launch::deferred;
}

}  // namespace borelli
