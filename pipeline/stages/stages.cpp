#include "pipeline/stages/stages.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "error/json_text.hpp"
#include "pipeline/files/digest.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* left_files = "left_by_earlier_runs";

// the kernel's peak of resident memory; writing 5 to clear_refs resets it (proc(5))
void restart_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

// Files and their sizes as run.json records them.
Result<json> outputs_of(const Stage& stage, const json& answer, const fs::path& folder) {
  std::vector<std::string> files = stage.outputs;
  if (answer.contains("files")) files = answer["files"].get<std::vector<std::string>>();
  json outputs = json::object();
  for (const auto& file : files) {
    std::error_code problem;
    const auto bytes = fs::file_size(folder / file, problem);
    if (problem)
      return failure(stage.name,
                     "ended without writing " + (folder / file).string() + "; please report this");
    outputs[file] = bytes;
  }
  return outputs;
}

// SHA-256 of each output file of the stage.
Result<json> digests_of_outputs(const json& outputs, const fs::path& folder) {
  json digests = json::object();
  for (const auto& [file, bytes] : outputs.items()) {
    const auto digest = digest_of(folder / file);
    if (!digest) return tl::unexpected(digest.error());
    digests[file] = *digest;
  }
  return digests;
}

// The last run's entry of a stage, without its remarks on edits by hand; null if there is none.
json past_entry(const json& before, const std::string& stage) {
  json past;
  if (before.contains("stages"))
    for (const auto& entry : before["stages"])
      if (entry.is_object() && entry.value("stage", "") == stage) past = entry;
  if (!past.contains("by_hand")) return past;
  json others = json::array();
  for (const auto& warning : past.value("warnings", json::array()))
    if (std::ranges::find(past["by_hand"], warning) == past["by_hand"].end()) others.push_back(warning);
  past["warnings"] = others;
  past.erase("by_hand");
  return past;
}

// Files of the folder that earlier runs wrote, as `before` records them, and that no stage of `now` writes.
std::vector<std::string> left_over(const json& before, const json& now, const fs::path& folder) {
  std::set<std::string> files;
  const auto each_output = [](const json& record, auto&& take) {
    for (const json& stage : record.value("stages", json::array())) {
      const json outputs = stage.value("outputs", json::object());
      for (const auto& entry : outputs.items()) take(entry.key());
    }
  };
  for (const json& file : before.value(left_files, json::array())) files.insert(file.get<std::string>());
  each_output(before, [&](const std::string& file) { files.insert(file); });
  each_output(now, [&](const std::string& file) { files.erase(file); });
  std::error_code absent;
  std::erase_if(files, [&](const std::string& file) { return !fs::exists(folder / file, absent); });
  return {files.begin(), files.end()};
}

struct ChangeByHand {
  EditableOutput output;
  std::string digest;  // present digest
};

// Compares the entry of the last run with the files in the folder.
struct Standing {
  bool same_key = false;   // made with these settings and inputs
  bool all_there = false;  // every file exists; those not editable are unchanged
  std::vector<ChangeByHand> by_hand;

  bool done() const { return same_key && all_there && by_hand.empty(); }
};

Standing standing_of(const Stage& stage, const json& past, const std::string& key, const fs::path& folder) {
  Standing standing;
  if (!past.is_object() || !past.contains("outputs") || !past["outputs"].is_object()) return standing;
  const json digests = past.value("digests", json::object());
  standing.same_key = past.value("key", "") == key;
  standing.all_there = true;
  for (const auto& [file, bytes] : past["outputs"].items()) {
    const auto editable = std::ranges::find(stage.editable, file, &EditableOutput::file);
    std::error_code problem;
    const auto size = fs::file_size(folder / file, problem);
    const bool may_differ = editable != stage.editable.end();
    if (problem || !digests.contains(file) || (!may_differ && size != bytes)) {
      standing.all_there = false;
      continue;
    }
    const auto digest = digest_of(folder / file);
    if (digest && json(*digest) == digests[file]) continue;
    if (digest && may_differ)
      standing.by_hand.push_back({*editable, *digest});
    else
      standing.all_there = false;
  }
  return standing;
}

// Whether the edited files may stay: true if the stage need not remake any other file. Else the error says
// so.
Result<void> keep_by_hand(const Stage& stage, const Standing& standing, const fs::path& folder) {
  const bool all_editable = stage.editable.size() == stage.outputs.size();
  if (standing.all_there && (standing.same_key || all_editable)) return {};
  return bad_use((folder / standing.by_hand.front().output.file).string(),
                 fmt::format("was changed by hand, but the stage '{}' would overwrite it, because {}; move "
                             "the file away, or give --force to repeat everything",
                             stage.name,
                             standing.all_there ? "its settings or inputs have changed"
                                                : "another of its files is missing or damaged"));
}

// The entry of a stage whose files were edited by hand.
json entry_by_hand(json past, const Standing& standing) {
  past["by_hand"] = json::array();
  for (const auto& [output, digest] : standing.by_hand)
    past["by_hand"].push_back(
        fmt::format("{} was changed by hand and is kept{}{}; --force writes it again", output.file,
                    output.used.empty() ? "" : ", although later stages read " + output.used,
                    standing.same_key ? "" : ", although the settings or inputs behind it have changed"));
  if (!past.contains("warnings")) past["warnings"] = json::array();
  past["warnings"].insert(past["warnings"].end(), past["by_hand"].begin(), past["by_hand"].end());
  return past;
}

// The three longest stages, each with its share of all stages' seconds.
json slowest_of(const json& stages) {
  std::vector<std::pair<double, std::string>> took;
  double all = 0;
  for (const json& stage : stages) {
    const double seconds = stage.value("seconds", 0.0);
    all += seconds;
    took.emplace_back(seconds, stage.value("stage", ""));
  }
  std::ranges::stable_sort(took, std::ranges::greater{}, &std::pair<double, std::string>::first);
  json slowest = json::array();
  for (std::size_t n = 0; n < std::min<std::size_t>(3, took.size()); ++n)
    slowest.push_back({{"stage", took[n].second},
                       {"seconds", took[n].first},
                       {"share", all > 0 ? took[n].first / all : 0.0}});
  return slowest;
}

// Runs the stages and tracks their progress. A worker thread repeatedly takes the first ready stage; if
// another is ready, it starts a thread for it.
class StagesAtWork {
 public:
  StagesAtWork(const fs::path& folder, const json& head, const json& before, const std::vector<Stage>& stages,
               int threads, const StageObserver& observer)
      : folder_(folder),
        head_(head),
        before_(before),
        stages_(stages),
        observer_(observer),
        most_threads_(static_cast<unsigned>(threads > 0 ? threads : all_threads)),
        turns_(stages.size()) {}

  Result<json> run() {
    work();
    // a helper may have started another one before it ended
    for (auto other = a_helper(); other.joinable(); other = a_helper()) other.join();
    if (thrown_) std::rethrow_exception(thrown_);
    for (const Turn& turn : turns_)
      if (turn.error) return tl::unexpected(*turn.error);
    json whole = record();
    if (const auto left = left_over(before_, whole, folder_); !left.empty()) {
      whole[left_files] = left;
      observer_.warns(
          stages_.back(),
          fmt::format("an earlier run with other settings wrote {}; this run did not, and keeps {}",
                      fmt::join(left, ", "), left.size() == 1 ? "it" : "them"));
    }
    whole["slowest"] = slowest_of(whole["stages"]);
    if (auto written = write_whole(folder_ / "run.json", json_text(whole, 2) + "\n"); !written)
      return tl::unexpected(written.error());
    return whole;
  }

 private:
  struct Turn {
    bool begun = false, at_work = false;
    json entry;  // entry of run.json, once done
    std::string key;
    double peak_memory_mib = 0;  // before a later stage reset the kernel's peak
    std::optional<Error> error;
  };

  void work() {
    std::unique_lock lock(mutex_);
    ++threads_;
    try {
      while (const auto n = ready()) {
        turns_[*n].begun = true;
        if (auto to_do = begin(*n); !to_do)
          fail(*n, to_do.error());
        else if (*to_do) {
          if (ready() && threads_ < most_threads_) helpers_.emplace_back([this] { work(); });
          if (auto done = carry_out(*n, lock); !done) fail(*n, done.error());
        }
      }
    } catch (...) {  // exceptions must not leave a thread
      if (!lock.owns_lock()) lock.lock();
      thrown_ = std::current_exception();
    }
    --threads_;
  }

  void fail(std::size_t n, const Error& error) {
    turns_[n].error = error;
    if (!in_vain(n)) observer_.fails(stages_[n], error);
  }

  // Whether the run ends without this stage, because an earlier one failed.
  bool in_vain(std::size_t n) const {
    return thrown_ || std::any_of(turns_.begin(), turns_.begin() + static_cast<std::ptrdiff_t>(n),
                                  [](const Turn& turn) { return turn.error.has_value(); });
  }

  // The first ready stage that has not begun; none after a failed stage.
  std::optional<std::size_t> ready() const {
    const auto done = [&](const std::string& need) { return !turns_[index_of(need)].entry.is_null(); };
    for (std::size_t n = 0; n < stages_.size() && !turns_[n].error && !thrown_; ++n)
      if (!turns_[n].begun && std::ranges::all_of(stages_[n].needs, done) &&
          std::ranges::all_of(stages_[n].after, done))
        return n;
    return std::nullopt;
  }

  std::size_t index_of(const std::string& stage) const {
    return static_cast<std::size_t>(std::ranges::find(stages_, stage, &Stage::name) - stages_.begin());
  }

  // Whether a stage has anything to do; if not, it keeps its entry.
  Result<bool> begin(std::size_t n) {
    const Stage& stage = stages_[n];
    Turn& turn = turns_[n];
    json identity = {{"stage", stage.name},
                     {"settings", stage.settings},
                     {"inputs", head_.value("inputs", json())},
                     {"program", head_.value("program", "")}};
    for (const auto& need : stage.needs) identity["needs"].push_back(turns_[index_of(need)].key);
    const std::string key = turn.key = digest_of_bytes(json_text(identity, -1));

    const json past = past_entry(before_, stage.name);
    const Standing standing = standing_of(stage, past, key, folder_);
    if (!standing.by_hand.empty()) {
      if (auto fine = keep_by_hand(stage, standing, folder_); !fine) return tl::unexpected(fine.error());
      for (const auto& [output, digest] : standing.by_hand)
        if (output.used.empty()) turn.key = digest_of_bytes(turn.key + digest);
      turn.entry = entry_by_hand(past, standing);
    } else if (standing.done()) {
      turn.entry = past;
    } else {
      observer_.begins(stage);
      return true;
    }
    observer_.skipped(stage);
    report_warnings(n);
    return false;
  }

  // Does the stage's work without holding the lock, and records it.
  Result<void> carry_out(std::size_t n, std::unique_lock<std::mutex>& lock) {
    const Stage& stage = stages_[n];
    Turn& turn = turns_[n];
    for (Turn& other : turns_)
      if (other.at_work) other.peak_memory_mib = std::max(other.peak_memory_mib, peak_memory_mib());
    restart_peak_memory();
    turn.at_work = true;
    const json so_far = record();

    lock.unlock();
    const auto began = std::chrono::steady_clock::now();
    auto answer = stage.work(
        [&](double fraction) {
          const std::lock_guard telling(mutex_);
          observer_.progress(stage, fraction);
          return !in_vain(n);
        },
        so_far);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    const auto outputs = answer ? outputs_of(stage, *answer, folder_) : answer;
    const auto digests = outputs ? digests_of_outputs(*outputs, folder_) : outputs;
    lock.lock();

    turn.at_work = false;
    if (!digests) return tl::unexpected(digests.error());
    json entry = {{"stage", stage.name},
                  {"seconds", seconds},
                  {"peak_memory_mib", std::max(turn.peak_memory_mib, peak_memory_mib())},
                  {"outputs", *outputs},
                  {"settings", stage.settings},
                  {"key", turn.key}};
    answer->erase("files");
    entry["digests"] = *digests;
    entry.update(*answer);
    turn.entry = std::move(entry);
    if (auto written = write_whole(folder_ / "run.json", json_text(record_with_those_to_come(), 2) + "\n");
        !written)
      return written;
    observer_.ends(stage, seconds);
    report_warnings(n);
    return {};
  }

  void report_warnings(std::size_t n) const {
    for (const json& warning : turns_[n].entry.value("warnings", json::array()))
      if (warning.is_string()) observer_.warns(stages_[n], warning.get<std::string>());
  }

  // The record of the finished stages.
  json record() const {
    json so_far = head_;
    so_far["stages"] = json::array();
    for (const Turn& turn : turns_)
      if (!turn.entry.is_null()) so_far["stages"].push_back(turn.entry);
    return so_far;
  }

  // The same with the last run's entries of the remaining stages, so that an interrupted run forgets nothing.
  json record_with_those_to_come() const {
    json all = head_;
    all["stages"] = json::array();
    for (std::size_t n = 0; n < stages_.size(); ++n)
      if (const json entry =
              turns_[n].entry.is_null() ? past_entry(before_, stages_[n].name) : turns_[n].entry;
          entry.is_object())
        all["stages"].push_back(entry);
    if (const auto left = left_over(before_, all, folder_); !left.empty()) all[left_files] = left;
    return all;
  }

  std::thread a_helper() {
    const std::lock_guard lock(mutex_);
    if (helpers_.empty()) return {};
    std::thread one = std::move(helpers_.back());
    helpers_.pop_back();
    return one;
  }

  const fs::path& folder_;
  const json &head_, &before_;
  const std::vector<Stage>& stages_;
  const StageObserver& observer_;
  const unsigned most_threads_;

  std::mutex mutex_;  // guards all members below and the observer
  std::vector<Turn> turns_;
  std::vector<std::thread> helpers_;
  unsigned threads_ = 0;
  std::exception_ptr thrown_;
};

}  // namespace

json run_record_kinds() {
  const json texts = json::array({""});
  return {{"program", ""},
          {"settings", {{"mesh_tolerance_mm", 0}}},
          {"warnings", texts},
          {left_files, texts},
          {"stages", json::array({{{"stage", ""},
                                   {"key", ""},
                                   {"seconds", 0},
                                   {"mass_kg", 0},
                                   {"tolerance", {{"met", true}, {"in_words", ""}}},
                                   {"economy", {{"in_words", ""}}},
                                   {"outputs", json::object()},
                                   {"digests", json::object()},
                                   {"warnings", texts},
                                   {"by_hand", texts}}})}};
}

Result<json> run_stages(const FolderLock& lock, const json& head, const std::vector<Stage>& stages,
                        bool force, int threads, const StageObserver& observer) {
  const fs::path& folder = lock.folder();
  for (const Stage& stage : stages)
    for (const std::string& output : stage.outputs)
      if (auto fine = check_writable(folder / output); !fine) return tl::unexpected(fine.error());
  const fs::path record_path = folder / "run.json";
  json before = json::object();
  if (std::error_code problem; fs::exists(record_path, problem)) {
    const auto bytes = read_input_file(record_path);
    if (!bytes && !force) return tl::unexpected(bytes.error());
    auto parsed = parse_json(bytes.value_or(""), record_path.string());
    if (parsed)
      if (auto fine = check_kinds(*parsed, run_record_kinds(), record_path.string()); !fine)
        parsed = tl::unexpected(fine.error());
    if (parsed)
      before = force ? json{{left_files, left_over(*parsed, json::object(), folder)}} : std::move(*parsed);
    else if (!force)
      return failure(
          parsed.error().where,
          parsed.error().what + "; this is not the record of a run: remove the file, or give --force");
  }
  sweep_partial_files_below(folder);
  return StagesAtWork(folder, head, before, stages, threads, observer).run();
}

}  // namespace borelli
