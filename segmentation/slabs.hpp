// Work shared among threads by slices of a volume.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace borelli {

/// Runs work(first, last) on disjoint ranges that make up [0, count), one range per thread. `threads` 0: as
/// many as the machine has. `work` must not throw.
template <class Work>
void in_slabs(std::int64_t count, int threads, const Work& work) {
  const std::int64_t wanted = threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
  const std::int64_t n = std::clamp<std::int64_t>(wanted, 1, std::max<std::int64_t>(count, 1));
  std::vector<std::thread> team;
  for (std::int64_t t = 1; t < n; ++t)
    team.emplace_back([&, t] { work(count * t / n, count * (t + 1) / n); });
  work(0, count / n);
  for (auto& thread : team) thread.join();
}

/// The same in more ranges than threads, each of which takes the next one that is left: where some take much
/// longer than others.
template <class Work>
void in_turns(std::int64_t count, int threads, const Work& work) {
  const std::int64_t ranges = std::clamp<std::int64_t>(count, 1, 64);
  std::atomic<std::int64_t> next = 0;
  const std::int64_t wanted = threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
  in_slabs(std::min(wanted, ranges), threads, [&](std::int64_t, std::int64_t) {
    for (std::int64_t n = next++; n < ranges; n = next++) work(count * n / ranges, count * (n + 1) / ranges);
  });
}

}  // namespace borelli
