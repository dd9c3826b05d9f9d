#include "pipeline/verbs/checkpoint.hpp"

#include <fmt/core.h>

#include <array>
#include <csignal>
#include <ctime>
#include <filesystem>

#include "dynamics/numbers/keeper.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

constexpr std::array signals{SIGINT, SIGTERM, SIGHUP};
constexpr double together = 1;  // s: signals this soon after the first count as the same one
volatile std::sig_atomic_t asked_to_stop = 0;
timespec first_asked;
std::array<struct sigaction, signals.size()> before;

extern "C" void ask_to_stop(int signal) {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (asked_to_stop == 0) {
    first_asked = now;
    asked_to_stop = signal;
    return;
  }
  const double since =
      double(now.tv_sec - first_asked.tv_sec) + 1e-9 * double(now.tv_nsec - first_asked.tv_nsec);
  if (since < together) return;
  for (std::size_t i = 0; i < signals.size(); ++i)
    if (signals[i] == signal) sigaction(signal, &before[i], nullptr);
  raise(signal);  // delivered when this handler returns
}

}  // namespace

CheckpointFile::CheckpointFile(std::string path, double every)
    : path_(std::move(path)), every_(every), last_(std::chrono::steady_clock::now()) {
  asked_to_stop = 0;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    struct sigaction action {};
    action.sa_handler = ask_to_stop;
    sigemptyset(&action.sa_mask);
    for (const int other : signals) sigaddset(&action.sa_mask, other);
    sigaction(signals[i], nullptr, &before[i]);
    if (before[i].sa_handler != SIG_IGN) sigaction(signals[i], &action, nullptr);
  }
}

CheckpointFile::~CheckpointFile() { run_is_over(); }

void CheckpointFile::run_is_over() {
  if (!listening_) return;
  listening_ = false;
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before[i], nullptr);
  if (asked_to_stop != 0 && !stopped_) raise(asked_to_stop);
}

Result<void> CheckpointFile::watch(const std::string& scene, Observer& observer) {
  header_ =
      fmt::format("borelli checkpoint, program {}, scene {:016x}\n", BORELLI_VERSION, checksum_of(scene));
  sweep_partial_files(path_);
  if (std::error_code problem; std::filesystem::exists(path_, problem)) {
    const auto bytes = read_input_file(path_, any_size);
    if (!bytes) return tl::unexpected(bytes.error());
    if (!bytes->starts_with("borelli checkpoint, "))
      return bad_use(path_, "exists already and is not a checkpoint; name another file");
    if (!bytes->starts_with(header_))
      return bad_use(path_,
                     "is the checkpoint of another scene, of other settings or of another version of the "
                     "program; remove it, or name another file");
    observer.checkpoint = bytes->substr(header_.size());
  } else if (auto fine = check_writable(path_); !fine) {
    return fine;
  }
  observer.keep = [this](const std::string& bytes) { written_ = write_whole(path_, header_ + bytes); };
  observer.keep_due = [this] {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < every_) return false;
    last_ = now;
    return true;
  };
  observer.progress = [this, progress = std::move(observer.progress)](double t) {
    stopped_ = asked_to_stop != 0;
    return (!progress || progress(t)) && !stopped_;
  };
  return {};
}

void CheckpointFile::remove() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace borelli
