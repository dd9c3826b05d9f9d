// The joint angles, moments and ground forces of a captured motion as JSON, for the report and other
// programs.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "pipeline/motion/captured_motion.hpp"
#include "pipeline/motion/effort_bands.hpp"

namespace borelli {

/// The members of the object:
///   source       what was recorded, in words, as given
///   mass_kg      of the body
///   times        s
///   coordinates  one for each rotation between two segments; a ball has three
///     name, label, joint, solid
///     angle_deg  a ball's are the components of its rotation vector
///     moment     N m
///     deviation  N m, one standard deviation; only with bands
///     shares     of the variance, by cause; only with bands
///     power      W
///   residuals    as residual_report
///   forces       of each foot on a plate: name, solid, and at each time `force` (N, world) and `point` (m, world;
///                null without contact)
nlohmann::json effort_report(const CapturedMotion& motion, const System& system,
                             const std::optional<EffortBands>& bands, const std::string& source);

/// The forces and moments left at the root: [{"coordinate", "unit", "rms", "peak", "percent_of_peak_force"}];
/// the percentage only for forces, and only if some were measured.
nlohmann::json residual_report(const RecordedEfforts& efforts);

}  // namespace borelli
