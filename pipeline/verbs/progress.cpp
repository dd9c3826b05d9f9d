#include "pipeline/verbs/progress.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

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
  if (!quiet_ && terminal_ && !what_.empty()) fmt::print(stderr, "\n");  // left in the middle by an error
}

void ProgressBar::begin(const std::string& what) {
  what_ = what;
  if (quiet_) return;
  drawn_ = std::chrono::steady_clock::now();
  if (terminal_)
    draw(0);
  else
    fmt::print(stderr, "{} ...\n", what_);
}

void ProgressBar::update(double fraction) {
  if (quiet_ || what_.empty()) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < between_) return;
  drawn_ = now;
  if (terminal_)
    draw(fraction);
  else
    fmt::print(stderr, "{} ... {:.0f} %\n", what_, 100 * std::clamp(fraction, 0.0, 1.0));
}

void ProgressBar::draw(double fraction) {
  const int full = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * bar_width);
  fmt::print(
      stderr, "\r\x1b[K{:<14} [{}{}] {:3.0f} %", what_, std::string(static_cast<std::size_t>(full), '#'),
      std::string(static_cast<std::size_t>(bar_width - full), ' '), 100 * std::clamp(fraction, 0.0, 1.0));
  std::fflush(stderr);
}

void ProgressBar::end(const std::string& outcome) {
  if (!quiet_) fmt::print(stderr, "{}{:<14} {}\n", terminal_ ? "\r\x1b[K" : "", what_, outcome);
  what_.clear();
}

void say_when_stopped(const char* words) noexcept { when_stopped = words; }
const char* words_when_stopped() noexcept { return when_stopped; }

}  // namespace borelli
