// Saves the rows of a running simulation beside its output, so that they survive a killed run.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "dynamics/run/simulate.hpp"

namespace borelli {

/// Writes `x.partial.h5` for the output `x.h5`, and removes it in the destructor. The file can be read at any
/// time. Writing takes at most a fiftieth of the run's time.
class UnfinishedRows {
 public:
  /// `scene`: the text of the scene, for write_trajectory.
  UnfinishedRows(const std::filesystem::path& output, std::string scene);
  ~UnfinishedRows();
  UnfinishedRows(const UnfinishedRows&) = delete;
  UnfinishedRows& operator=(const UnfinishedRows&) = delete;

  /// Makes the observed run write its rows here. This object must outlive the run.
  void watch(Observer& observer);

 private:
  using Clock = std::chrono::steady_clock;

  void write(const Trajectory& so_far);

  std::filesystem::path path_;
  std::string scene_;
  Clock::time_point begun_, next_;
};

}  // namespace borelli
