// Checkpoint file of an interruptible run: saved from time to time and on ^C; the same command resumes it.
#pragma once

#include <chrono>
#include <string>

#include "dynamics/run/simulate.hpp"

namespace borelli {

class CheckpointFile {
 public:
  /// Handles SIGINT, SIGTERM and SIGHUP until the run is over. The first signal stops the run after its step.
  /// Another one a second or more later ends the program as usual. (A job's owner may send two signals at
  /// once.)
  CheckpointFile(std::string path, double every);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Resumes from the file if it exists, and saves the run to it every `every` seconds and when the run is
  /// stopped. `scene`: text of the scene with its settings. Errors: the file does not belong to this run.
  Result<void> watch(const std::string& scene, Observer& observer);
  /// Call when the run ended or was stopped: restores the previous signal handlers. A signal that came too
  /// late to stop the run then ends the program at once.
  void run_is_over();
  /// Whether the run was stopped by a signal.
  bool stopped() const { return stopped_; }
  /// The error of writing the file, if any.
  const Result<void>& written() const { return written_; }
  /// Removes the file, once the run's result has been delivered.
  void remove() const;

 private:
  std::string path_, header_;
  std::chrono::duration<double> every_;
  std::chrono::steady_clock::time_point last_;
  Result<void> written_;
  bool listening_ = true, stopped_ = false;
};

}  // namespace borelli
