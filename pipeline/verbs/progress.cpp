#include "pipeline/verbs/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

#include "pipeline/verbs/say.hpp"

namespace borelli {
namespace {

constexpr int bar_width = 30;
std::atomic<const char*> when_stopped = nullptr;

constexpr double first_estimate = 5;   // s: before this the time left is too uncertain
constexpr double shortest_left = 120;  // s: less is not worth showing

std::string time_words(double seconds) {
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 48 * 3600.) return fmt::format("{:.0f} h", seconds / 3600);
  if (seconds < 2 * 365.25 * 86400) return fmt::format("{:.0f} days", seconds / 86400);
  return fmt::format("{:.3g} years", seconds / (365.25 * 86400));
}

}  // namespace

ProgressBar::ProgressBar(bool quiet, std::chrono::milliseconds between_lines)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      between_(terminal_ ? std::chrono::milliseconds(50) : between_lines) {}

ProgressBar::~ProgressBar() {
  if (!quiet_ && terminal_ && !works_.empty()) say("\n");  // interrupted by an error
}

void ProgressBar::begin(const std::string& what) {
  works_.push_back({.what = what, .began = std::chrono::steady_clock::now()});
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
    say("{} ... {}\n", work->what, progress_of(*work));
}

std::string progress_words(double seconds, double fraction) {
  const double left = fraction > 0 ? seconds * (1 - fraction) / fraction : 0;
  if (seconds < first_estimate || left < shortest_left) return fmt::format("{:.0f} %", 100 * fraction);
  return fmt::format("{:.2g} %, about {} left", 100 * fraction, time_words(left));
}

std::string ProgressBar::progress_of(const Work& work) const {
  return progress_words(std::chrono::duration<double>(drawn_ - work.began).count(), work.fraction);
}

void ProgressBar::draw(const Work& work) {
  const int full = static_cast<int>(work.fraction * bar_width);
  say("\r\x1b[K{:<14} [{}{}] {:>5}", work.what, std::string(static_cast<std::size_t>(full), '#'),
      std::string(static_cast<std::size_t>(bar_width - full), ' '), progress_of(work));
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
