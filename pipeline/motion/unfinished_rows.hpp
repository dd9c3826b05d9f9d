// The rows of a run that is not at its end, in a file beside its output: what is left if it is killed.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "dynamics/simulate.hpp"

namespace borelli {

/// `x.partial.h5` for `x.h5`, gone with this object. Each writing of it is whole, so that it can be read at
/// any time. Writing takes at most a fiftieth of the run's time.
class UnfinishedRows {
 public:
  /// `scene`: its text, as write_trajectory has it.
  UnfinishedRows(const std::filesystem::path& output, std::string scene);
  ~UnfinishedRows();
  UnfinishedRows(const UnfinishedRows&) = delete;
  UnfinishedRows& operator=(const UnfinishedRows&) = delete;

  /// `this` must outlive the run.
  void watch(Observer& observer);

 private:
  using Clock = std::chrono::steady_clock;

  void write(const Trajectory& so_far);

  std::filesystem::path path_;
  std::string scene_;
  Clock::time_point begun_, next_;
};

}  // namespace borelli
