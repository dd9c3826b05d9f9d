#include "pipeline/motion/unfinished_rows.hpp"

#include <algorithm>
#include <system_error>

#include "pipeline/trajectory_file.hpp"
#include "pipeline/whole_file.hpp"

namespace borelli {
namespace {

constexpr std::chrono::seconds first_writing{1};
constexpr int fraction = 50;  // of the run's time, that is lost at most; of which writing takes at most one

}  // namespace

UnfinishedRows::UnfinishedRows(const std::filesystem::path& output, std::string scene)
    : path_(output), scene_(std::move(scene)), begun_(Clock::now()), next_(begun_ + first_writing) {
  path_.replace_extension(".partial" + output.extension().string());
  sweep_partial_files(path_);
}

UnfinishedRows::~UnfinishedRows() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void UnfinishedRows::watch(Observer& observer) {
  observer.rows = [this](const Trajectory& so_far) { write(so_far); };
  observer.rows_due = [this] { return Clock::now() >= next_; };
}

void UnfinishedRows::write(const Trajectory& so_far) {
  const auto from = Clock::now();
  // what cannot be written is no reason to end the run: the output itself may have room yet
  static_cast<void>(write_whole(
      path_, [&](const std::filesystem::path& beside) { return write_trajectory(so_far, scene_, beside); }));
  const auto now = Clock::now();
  next_ =
      now + std::max({Clock::duration(first_writing), (now - begun_) / fraction, (now - from) * fraction});
}

}  // namespace borelli
