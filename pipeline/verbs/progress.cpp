#include "pipeline/verbs/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

#include "pipeline/verbs/say.hpp"

namespace borelli {
namespace {

constexpr int bar_width = 30;
std::atomic<const char*> when_stopped = nullptr;

}  // namespace

ProgressBar::ProgressBar(bool quiet, std::chrono::milliseconds between_lines)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      between_(terminal_ ? std::chrono::milliseconds(50) : between_lines) {}

ProgressBar::~ProgressBar() {
  if (!quiet_ && terminal_ && !works_.empty()) say("\n");  // left in the middle by an error
}

void ProgressBar::begin(const std::string& what) {
  works_.push_back({what});
  if (quiet_) return;
  drawn_ = std::chrono::steady_clock::now();
  if (!terminal_)
    say("{} ...\n", what);
  else if (works_.size() == 1)
    draw(works_.front());
}

std::vector<ProgressBar::Work>::iterator ProgressBar::find(std::string_view what) {
  return what.empty() ? works_.begin() : std::ranges::find(works_, what, &Work::what);
}

void ProgressBar::update(double fraction, std::string_view what) {
  const auto work = find(what);
  if (quiet_ || work == works_.end()) return;
  work->fraction = std::clamp(fraction, 0.0, 1.0);
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < between_) return;
  drawn_ = now;
  if (terminal_)
    draw(works_.front());
  else
    say("{} ... {:.0f} %\n", work->what, 100 * work->fraction);
}

void ProgressBar::draw(const Work& work) {
  const int full = static_cast<int>(work.fraction * bar_width);
  say("\r\x1b[K{:<14} [{}{}] {:3.0f} %", work.what, std::string(static_cast<std::size_t>(full), '#'),
      std::string(static_cast<std::size_t>(bar_width - full), ' '), 100 * work.fraction);
  std::fflush(stderr);
}

void ProgressBar::end(const std::string& outcome, std::string_view what) {
  const auto work = find(what);
  if (work == works_.end()) return;
  if (!quiet_) say("{}{:<14} {}\n", terminal_ ? "\r\x1b[K" : "", work->what, outcome);
  works_.erase(work);
  if (!quiet_ && terminal_ && !works_.empty()) draw(works_.front());
}

void say_when_stopped(const char* words) noexcept { when_stopped = words; }
const char* words_when_stopped() noexcept { return when_stopped; }

}  // namespace borelli
