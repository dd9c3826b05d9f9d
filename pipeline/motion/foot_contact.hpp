// Which foot stands on which force plate.
#pragma once

#include <string>
#include <vector>

#include "dynamics/inverse/recorded_motion.hpp"
#include "dynamics/scene/scene.hpp"
#include "pipeline/motion/external_loads.hpp"

namespace borelli {

struct FootLoads {
  std::vector<ExternalLoad> loads;  ///< per plate and foot that stood on it
  std::vector<std::string> warnings;
};

/// The solids that are feet by their names: those with "calcn" or "calcaneus", else those with "foot".
std::vector<std::string> feet_of(const System& system);

/// Gives each stance on a plate (an unbroken load of at least 20 N) to the foot whose origin is nearest to the
/// centre of pressure, on average over the stance. A stance farther than half a metre from every foot is left
/// out; one that two feet share within 0.1 m of each other is told, since one plate cannot tell them apart.
/// Forces are in the axes of the scene. Errors: no feet; a foot that the system does not have.
Result<FootLoads> loads_on_feet(const System& system, const RecordedMotion& motion,
                                const std::vector<MeasuredForce>& forces,
                                const std::vector<std::string>& feet);

}  // namespace borelli
