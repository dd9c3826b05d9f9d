// Work shared among threads by slices of a volume.
#pragma once

#include <algorithm>
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

}  // namespace borelli
