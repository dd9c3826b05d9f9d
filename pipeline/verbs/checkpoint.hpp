// The file of a run that may be broken off: kept from time to time and on ^C, taken up by the same command.
#pragma once

#include <chrono>
#include <string>

#include "dynamics/simulate.hpp"

namespace borelli {

class CheckpointFile {
 public:
  /// Takes over SIGINT, SIGTERM and SIGHUP while it lives: the first of them stops the run after its step, a
  /// second one ends the program as ever.
  CheckpointFile(std::string path, double every);
  ~CheckpointFile();
  CheckpointFile(const CheckpointFile&) = delete;
  CheckpointFile& operator=(const CheckpointFile&) = delete;

  /// Takes up what the file holds, if it is there, and has the run kept in it every so many seconds and when
  /// it is stopped. `scene`: its text with the settings. Fails where the file is not such a run's.
  Result<void> watch(const std::string& scene, Observer& observer);
  /// Whether the run was stopped by a signal.
  bool stopped() const;
  /// What went wrong in writing, if anything did.
  const Result<void>& written() const { return written_; }
  /// The run has come to its end: the file goes.
  void finish() const;

 private:
  std::string path_, header_;
  std::chrono::duration<double> every_;
  std::chrono::steady_clock::time_point last_;
  Result<void> written_;
};

}  // namespace borelli
