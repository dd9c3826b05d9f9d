#include "pipeline/export/display.hpp"

#include <X11/Xlib.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

namespace borelli {
namespace {

// Xvfb starts anew when its last client leaves, and for that moment answers nobody: neither is one refusal
// the last word, ...
Display* open_patiently(const char* name) {
  for (int attempt = 0; attempt < 5; ++attempt) {
    if (Display* const display = XOpenDisplay(name)) return display;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return nullptr;
}

}  // namespace

bool display_answers() {
  const char* const name = std::getenv("DISPLAY");
  if (!name || !*name) return false;
  static std::map<std::string, Display*, std::less<>>
      open;  // ... nor is a display let go before the process ends
  Display*& display = open[name];
  if (!display) display = open_patiently(name);
  return display != nullptr;
}

}  // namespace borelli
