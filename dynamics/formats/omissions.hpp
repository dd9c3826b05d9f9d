// Collects what a model file cannot hold, as sentences for the user.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "dynamics/scene/settings.hpp"

namespace borelli {

/// Losses of a written model. Names with the same reason share one sentence, "reason: a, b".
class Omissions {
 public:
  /// `name`: what is lost; empty: the reason says it all.
  void add(const std::string& reason, const std::string& name = "") {
    auto found = std::find_if(lists_.begin(), lists_.end(), [&](const auto& l) { return l.first == reason; });
    if (found == lists_.end()) found = lists_.insert(lists_.end(), {reason, {}});
    if (!name.empty()) found->second.push_back(name);
  }

  std::vector<std::string> sentences() const {
    std::vector<std::string> out;
    for (const auto& [reason, names] : lists_) {
      std::string& sentence = out.emplace_back(reason);
      for (std::size_t i = 0; i < names.size(); ++i) sentence += (i == 0 ? ": " : ", ") + names[i];
    }
    return out;
  }

 private:
  std::vector<std::pair<std::string, std::vector<std::string>>> lists_;  // reasons with their names
};

/// An effort or constraint by name and kind: "spring (point_spring)".
std::string named_with_kind(const auto& part) {
  return fmt::format("{} ({})", part.name,
                     std::visit([](const auto& kind) { return std::string(kind.kind); }, part.kind));
}

/// Adds that no model file holds settings of a run, if they differ from the defaults.
inline void list_run_settings(const SimulationSettings& settings, Omissions& lost) {
  const SimulationSettings usual;
  if (settings.method != usual.method || settings.tolerance != usual.tolerance ||
      settings.accuracy != usual.accuracy || settings.end_time != usual.end_time ||
      settings.output_interval != usual.output_interval)
    lost.add("the run's method, accuracy, length and output interval are not written");
}

}  // namespace borelli
