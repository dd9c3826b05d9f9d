// The joint angles, moments and ground forces of a captured motion as JSON, for the report and other programs.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "pipeline/motion/captured_motion.hpp"
#include "pipeline/motion/effort_bands.hpp"

namespace borelli {

/// {"source", "mass_kg", "times" (s), "coordinates": [{"name", "label", "joint", "solid", "angle_deg", "moment" (N m),
/// "deviation" (N m), "shares" (of the variance, by cause), "power" (W)}], "residuals": [{"coordinate", "unit",
/// "rms", "peak", "percent_of_peak_force"}], "forces": [{"name", "solid", "force" (N, world), "point" (m, world;
/// null where there is none)}]}. Coordinates: those of joints between two segments; a ball has three, whose
/// angles are its rotation vector's parts. Without bands "deviation" and "shares" are left out. Forces are taken
/// at the times of the efforts. `source`: what was recorded, in words.
nlohmann::json effort_report(const CapturedMotion& motion, const System& system,
                             const std::optional<EffortBands>& bands, const std::string& source);

/// The residuals alone, as in "residuals".
nlohmann::json residual_report(const RecordedEfforts& efforts);

}  // namespace borelli
