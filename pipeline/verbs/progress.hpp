// Shows the progress of long work on standard error: a bar on a terminal, plain lines otherwise.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace borelli {

/// Progress of work that has done `fraction` in `seconds`: "25 %"; if much time is left, "0.0012 %, about 23
/// h left".
std::string progress_words(double seconds, double fraction);

class ProgressBar {
 public:
  /// `quiet`: show nothing (with --json, standard error carries only errors). `between_lines`: interval of
  /// lines if standard error is not a terminal.
  explicit ProgressBar(bool quiet, std::chrono::milliseconds between_lines = std::chrono::seconds(30));
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Works may overlap; a terminal shows the bar of the oldest unfinished one.
  void begin(const std::string& what);
  /// `fraction`: 0 to 1. Draws at most twenty times a second on a terminal, otherwise a line every half
  /// minute, in the form of progress_words. `what`: which of the current works; empty: the only one.
  void update(double fraction, std::string_view what = {});
  void end(const std::string& outcome, std::string_view what = {});  ///< e.g. "1.3 s"; the line stays

 private:
  struct Work {
    std::string what;
    double fraction = 0;
    std::chrono::steady_clock::time_point began = {};
  };
  std::vector<Work>::iterator find(std::string_view what);
  void draw(const Work& work);
  std::string progress_of(const Work& work) const;
  bool quiet_, terminal_;
  std::chrono::milliseconds between_;
  std::vector<Work> works_;  // in the order of their start
  std::chrono::steady_clock::time_point drawn_;
};

/// Sets the sentence printed on standard error if a signal ends the program: a literal, since only the
/// pointer is kept; null: nothing.
void say_when_stopped(const char* words) noexcept;
/// The sentence set last. Safe in a signal handler.
const char* words_when_stopped() noexcept;

}  // namespace borelli
