// The file of a run that may be broken off: kept from time to time and on ^C, taken up by the same command.
#pragma once

#include <chrono>
#include <string>

#include "dynamics/run/simulate.hpp"

namespace borelli {

class CheckpointFile {
 public:
  /// Takes over SIGINT, SIGTERM and SIGHUP until the run is over: the first of them stops it after its step,
  /// others that come a second later or more end the program as ever. (Who ends a job may signal it twice.)
  CheckpointFile(std::string path, double every);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Takes up what the file holds, if it is there, and has the run kept in it every so many seconds and when
  /// it is stopped. `scene`: its text with the settings. Fails where the file is not such a run's.
  Result<void> watch(const std::string& scene, Observer& observer);
  /// The run has come to its end, or was stopped: signals do what they did before, one that came too late to
  /// stop it at once.
  void run_is_over();
  /// Whether the run was stopped by a signal.
  bool stopped() const { return stopped_; }
  /// What went wrong in writing, if anything did.
  const Result<void>& written() const { return written_; }
  /// What came of the run is where it was wanted: the file goes.
  void remove() const;

 private:
  std::string path_, header_;
  std::chrono::duration<double> every_;
  std::chrono::steady_clock::time_point last_;
  Result<void> written_;
  bool listening_ = true, stopped_ = false;
};

}  // namespace borelli
