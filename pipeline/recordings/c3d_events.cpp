#include "pipeline/recordings/c3d_events.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

std::vector<MotionEvent> events_of_header(std::string_view bytes, C3dProcessor processor, double start) {
  constexpr std::uint16_t four_characters = 12345;  // key of word 150; labels have two without it
  const bool four = c3d_word(bytes.data() + 298, processor) == four_characters;
  const int count = std::min<int>(c3d_word(bytes.data() + 300, processor), 18);
  std::vector<MotionEvent> out;
  for (int i = 0; i < count; ++i) {
    const double time = c3d_real(bytes.data() + 304 + 4 * i, processor);
    std::string label(bytes.substr(static_cast<std::size_t>(396 + (four ? 4 : 2) * i), four ? 4 : 2));
    while (!label.empty() && (label.back() == ' ' || label.back() == '\0')) label.pop_back();
    if (std::isfinite(time)) out.push_back({start + time, label, {}, {}, {}});
  }
  return out;
}

std::vector<MotionEvent> events_of_group(const C3dParameters& parameters,
                                         std::vector<std::string>& warnings) {
  const std::vector<double> times = parameters.numbers("EVENT", "TIMES");
  const std::vector<std::string> labels = parameters.texts("EVENT", "LABELS");
  const std::vector<std::string> contexts = parameters.texts("EVENT", "CONTEXTS");
  const std::vector<std::string> subjects = parameters.texts("EVENT", "SUBJECTS");
  const std::vector<std::string> descriptions = parameters.texts("EVENT", "DESCRIPTIONS");
  const double used = parameters.count("EVENT", "USED").value_or(static_cast<double>(times.size() / 2));
  if (used > static_cast<double>(times.size() / 2))
    warnings.push_back(
        fmt::format("EVENT:USED is {:g}, but EVENT:TIMES contains {}", used, times.size() / 2));
  const auto entry = [](const std::vector<std::string>& texts, std::size_t i) {
    return i < texts.size() ? texts[i] : std::string{};
  };
  std::vector<MotionEvent> out;
  for (std::size_t i = 0; 2 * i + 1 < times.size() && static_cast<double>(i) < used; ++i) {
    const double time = 60 * times[2 * i] + times[2 * i + 1];
    if (std::isfinite(time))
      out.push_back({time, entry(labels, i), entry(contexts, i), entry(subjects, i), entry(descriptions, i)});
  }
  return out;
}

}  // namespace

std::vector<MotionEvent> c3d_events(std::string_view bytes, C3dProcessor processor,
                                    const C3dParameters& parameters, const C3dLayout& layout,
                                    std::vector<std::string>& warnings) {
  std::vector<MotionEvent> out = events_of_group(parameters, warnings);
  const std::size_t of_group = out.size();
  for (MotionEvent& event : events_of_header(bytes, processor, (layout.first_frame - 1) / layout.rate)) {
    const bool known = std::any_of(
        out.begin(), out.begin() + static_cast<std::ptrdiff_t>(of_group),
        [&](const MotionEvent& other) { return std::abs(other.time - event.time) < 0.5 / layout.rate; });
    if (!known) out.push_back(std::move(event));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const MotionEvent& a, const MotionEvent& b) { return a.time < b.time; });
  return out;
}

}  // namespace borelli
