// The report's section on joint moments: the curves for the page's program, and tables that need no program.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "error/error.hpp"

namespace borelli {

struct EffortSection {
  /// The inputs with at most about 1500 samples of five digits, coordinates sorted (ankle, knee, hip, others;
  /// left before right). Each coordinate also has "group" ("knee"), "side" ("left", "right" or ""), "motion"
  /// ("flexion") and "peak": {"moment" (N m, signed, largest in size), "deviation", "time" (s), "power" (W),
  /// "power_time"}, found among all samples.
  nlohmann::json page;
  /// <section id="moments"> with heading, peaks and root residuals.
  std::string html;
};

/// `efforts` as effort_report (pipeline/motion) makes it. Errors name the coordinate or force whose values
/// are missing or of another number than "times".
Result<EffortSection> effort_section(const nlohmann::json& efforts);

}  // namespace borelli
