// Runs a list of stages that leave files, skips those that are done already, and keeps the account in
// run.json.
//
// A stage is done when run.json records it under the same key and its files have the digests recorded there.
// The key is a digest of the stage's name, its settings, and the keys of the stages that it needs, so that a
// change reruns exactly what depends on it.
//
// An editable file with another digest was changed by hand: it stays as the stage's result, with a warning,
// and what depends on it is done again.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/files/folder_lock.hpp"

namespace borelli {

/// Called with the part of a stage that is done, 0 to 1. False: a stage before this one failed, and with it
/// the run; this one is to end with an error, which nobody reads.
using StageProgress = std::function<bool(double fraction)>;

/// An output that a user may change by hand.
struct EditableOutput {
  std::string file;       ///< one of the stage's outputs
  std::string used = {};  ///< the output that later stages read in its place; empty: they read this one
};

struct Stage {
  std::string name;
  std::vector<std::string> needs;    ///< names of earlier stages whose results it uses
  nlohmann::json settings;           ///< all that its result depends on besides
  std::vector<std::string> outputs;  ///< files it leaves, relative to the run's folder
  /// Given run.json as far as it stands (the entries of those that it needs are there); answers what run.json
  /// is to say of this stage ("warnings" ...). A "files" in it takes the place of `outputs`; a "key" of ""
  /// has the stage done again by the next run.
  std::function<Result<nlohmann::json>(const StageProgress&, const nlohmann::json& record)> work;
  std::vector<EditableOutput> editable = {};
  /// Earlier stages that go first though it needs nothing of them: where others wait for what keeps all cores
  /// busy.
  std::vector<std::string> after = {};
};

/// What the caller shows: the stages that begin, their progress, and how they ended. Called by one thread at
/// a time, though not always by the same.
struct StageObserver {
  std::function<void(const Stage&)> begins = [](const Stage&) {};
  std::function<void(const Stage&, double fraction)> progress = [](const Stage&, double) {};
  std::function<void(const Stage&, double seconds)> ends = [](const Stage&, double) {};
  std::function<void(const Stage&)> skipped = [](const Stage&) {};
  /// Of a stage that ended or was skipped, what its record warns of.
  std::function<void(const Stage&, const std::string& warning)> warns = [](const Stage&, const auto&) {};
  /// At once, though stages beside it may still be at work; not of one that is to end since another failed.
  std::function<void(const Stage&, const Error&)> fails = [](const Stage&, const Error&) {};
};

/// The members of run.json that later runs and the report read: a pattern for check_kinds
/// (error/json_text.hpp).
nlohmann::json run_record_kinds();

/// Runs the stages inside the locked folder, each as soon as those that it needs are done, up to `threads`
/// side by side (0: as many as the machine has); `head` opens run.json (versions, inputs, settings) and takes
/// part in every key by its "inputs" and "program". Every stage's seconds, peak memory (MiB; the program's
/// while the stage ran) and answer are recorded as soon as it ends, in the order given; in the end "slowest"
/// names the three that took longest, each with its seconds and share of all stages' seconds. A stage with a
/// file that was changed by hand keeps it, and its entry has "by_hand", the warnings that say so. Answers
/// run.json as it stands in the end. Errors: a stage's (of several that fail the first one's in the order
/// given; what comes before it is still done; what comes after it is not begun, or told to stop by its
/// progress); outputs that cannot be written where they belong, before any work; a run.json that is no
/// record; a file changed by hand whose stage must be done again for its other files. `force` takes no notice
/// of changes by hand.
Result<nlohmann::json> run_stages(const FolderLock& lock, const nlohmann::json& head,
                                  const std::vector<Stage>& stages, bool force, int threads = 0,
                                  const StageObserver& observer = {});

}  // namespace borelli
