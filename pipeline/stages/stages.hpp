// Runs a list of stages that write files, skips those already done, and keeps the account in run.json.
//
// A stage is done when run.json records it under the same key and its files have the recorded digests. The
// key is a digest of the stage's name, its settings, and the keys of the stages it needs. So a change reruns
// exactly the stages that depend on it.
//
// An editable file with another digest was edited by hand: it stays as the stage's result, with a warning,
// and the stages that depend on it run again.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/files/folder_lock.hpp"

namespace borelli {

/// Receives the share of a stage that is done, 0 to 1. Returns false if an earlier stage failed, and with it
/// the run; the stage must then end with an error, which nobody reads.
using StageProgress = std::function<bool(double fraction)>;

/// An output that a user may edit by hand.
struct EditableOutput {
  std::string file;       ///< one of the stage's outputs
  std::string used = {};  ///< output that later stages read instead; empty: this one
};

struct Stage {
  std::string name;
  std::vector<std::string> needs;    ///< names of earlier stages whose results it uses
  nlohmann::json settings;           ///< everything else that its result depends on
  std::vector<std::string> outputs;  ///< files it writes, relative to the run's folder
  /// Does the work. `record` is run.json so far, with the entries of all needed stages. Returns the stage's
  /// entry for run.json ("warnings" ...). A "files" member replaces `outputs`. A "key" of "" makes the next
  /// run repeat the stage.
  std::function<Result<nlohmann::json>(const StageProgress&, const nlohmann::json& record)> work;
  std::vector<EditableOutput> editable = {};
  /// Earlier stages that should run first although it does not use their results: for instance when other
  /// stages wait for one that keeps all cores busy.
  std::vector<std::string> after = {};
};

/// Callbacks for the stages' starts, progress and ends. Called by one thread at a time, but not always the
/// same thread.
struct StageObserver {
  std::function<void(const Stage&)> begins = [](const Stage&) {};
  std::function<void(const Stage&, double fraction)> progress = [](const Stage&, double) {};
  std::function<void(const Stage&, double seconds)> ends = [](const Stage&, double) {};
  std::function<void(const Stage&)> skipped = [](const Stage&) {};
  /// Warnings in the record of a stage that ended or was skipped.
  std::function<void(const Stage&, const std::string& warning)> warns = [](const Stage&, const auto&) {};
  /// Called at once, while concurrent stages may still run; not called for a stage stopped because another
  /// failed.
  std::function<void(const Stage&, const Error&)> fails = [](const Stage&, const Error&) {};
};

/// Members of run.json that later runs and the report read: a pattern for check_kinds (error/json_text.hpp).
nlohmann::json run_record_kinds();

/// Runs the stages inside the locked folder. Each starts as soon as the stages it needs are done, up to
/// `threads` concurrently (0: as many as the machine has). `head` opens run.json (versions, inputs,
/// settings); its "inputs" and "program" are part of every key.
///
/// Every stage's seconds, peak memory (MiB; of the whole program while the stage ran) and entry are recorded
/// as soon as it ends, in the given order. At the end "slowest" names the three longest stages with their
/// seconds and share of all stages' seconds. A stage with a hand-edited file keeps it, and its entry has
/// "by_hand", the warnings about it. `force` ignores edits by hand. Files of earlier runs that no stage
/// writes any more stay; "left_by_earlier_runs" names them, and the observer hears of them with the last
/// stage. Returns the final run.json.
///
/// Errors: a stage's error. If several fail, the first in the given order counts; stages before it are still
/// finished, stages after it do not start or are stopped through their progress callback. Before any work:
/// outputs that cannot be written, or a run.json that is not a valid record. Also a hand-edited file whose
/// stage must run again for its other files.
Result<nlohmann::json> run_stages(const FolderLock& lock, const nlohmann::json& head,
                                  const std::vector<Stage>& stages, bool force, int threads = 0,
                                  const StageObserver& observer = {});

}  // namespace borelli
