// Assigns the loads of force plates to feet.
#pragma once

#include <string>
#include <vector>

#include "dynamics/inverse/recorded_motion.hpp"
#include "dynamics/scene/scene.hpp"
#include "pipeline/recordings/external_loads.hpp"

namespace borelli {

/// N: a plate with at least this load counts as stood on.
inline constexpr double least_load = 20;

struct FootLoads {
  std::vector<ExternalLoad> loads;  ///< one per plate and foot that stood on it
  std::vector<std::string> warnings;
};

/// Names of the solids that are feet: those that contain "calcn" or "calcaneus", otherwise "foot".
std::vector<std::string> feet_of(const System& system);

/// Gives each stance on a plate (an unbroken load of at least `least_load` for at least 0.05 s) to the foot
/// whose origin is nearest to the centre of pressure on average. A stance more than 0.5 m from every foot is
/// left out. If another foot is less than 0.1 m farther, a warning says so: one plate cannot separate them.
/// Forces are in the scene's axes. Errors: no feet; a foot that the system does not have.
Result<FootLoads> loads_on_feet(const System& system, const RecordedMotion& motion,
                                const std::vector<MeasuredForce>& forces,
                                const std::vector<std::string>& feet);

}  // namespace borelli
