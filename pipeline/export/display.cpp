#include "pipeline/export/display.hpp"

#include <X11/Xlib.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

namespace borelli {
namespace {

// Xvfb restarts when its last client leaves, and refuses connections for that moment. So try several times,
// ...
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
      open;  // ... and keep the display open until the process ends
  Display*& display = open[name];
  if (!display) display = open_patiently(name);
  return display != nullptr;
}

}  // namespace borelli
