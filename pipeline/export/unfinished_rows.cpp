#include "pipeline/export/unfinished_rows.hpp"

#include <algorithm>
#include <system_error>

#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/whole_file.hpp"

namespace borelli {
namespace {

constexpr std::chrono::seconds shortest_interval{1};
// writing takes at most a fiftieth of the run's time; a killed run loses about as much
constexpr int time_per_write = 50;

}  // namespace

UnfinishedRows::UnfinishedRows(const std::filesystem::path& output, std::string scene)
    : path_(output), scene_(std::move(scene)), begun_(Clock::now()), next_(begun_ + shortest_interval) {
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
  // a failure here does not end the run: the output itself may still find room
  static_cast<void>(write_whole(
      path_, [&](const std::filesystem::path& beside) { return write_trajectory(so_far, scene_, beside); }));
  const auto now = Clock::now();
  next_ = now + std::max({Clock::duration(shortest_interval), (now - begun_) / time_per_write,
                          (now - from) * time_per_write});
}

}  // namespace borelli
