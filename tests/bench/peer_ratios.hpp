// A table of medians: benchmarks named `x` (ours) against `x/peer` (another program).
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace borelli {

/// Prints the peer's time over ours after the runs. Times are processor time of the thread, ns; wall time for
/// benchmarks that use real time.
class PeerRatios : public benchmark::ConsoleReporter {
 public:
  explicit PeerRatios(std::string peer) : peer_(std::move(peer)) {}

  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs)
      if (!run.error_occurred && run.run_type == Run::RT_Iteration) {
        const bool real = run.run_name.time_type == "real_time";
        const double time = real ? run.GetAdjustedRealTime() : run.GetAdjustedCPUTime();
        times_[run.run_name.function_name].push_back(1e9 * time / GetTimeUnitMultiplier(run.time_unit));
      }
  }
  void Finalize() override {
    ConsoleReporter::Finalize();
    std::printf("%-40s %14s %14s %8s   (medians, ns)\n", "", "borelli", peer_.c_str(), "ratio");
    for (const auto& [name, times] : times_) {
      if (name.ends_with("/" + peer_)) continue;
      const double ours = median(times);
      std::printf("%-40s %14.1f", name.c_str(), ours);
      if (const auto other = times_.find(name + "/" + peer_); other != times_.end())
        std::printf(" %14.1f %8.2f", median(other->second), median(other->second) / ours);
      std::puts("");
    }
  }

 private:
  static double median(std::vector<double> times) {
    std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
    return times[times.size() / 2];
  }

  std::string peer_;
  std::map<std::string, std::vector<double>> times_;
};

}  // namespace borelli
