// Sets the feet of a body on the ground where the feet of a person of another size stood.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/inverse/recorded_motion.hpp"
#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "pipeline/recordings/external_loads.hpp"

namespace borelli {

struct FeetOnGround {
  FootSoles soles;                         ///< m, the world of the body's start
  std::vector<double> factors;             ///< per solid, size of the recorded person's model over the body's
  double length_ratio = 1;                 ///< of the body's legs to the recorded person's
  const std::vector<ExternalLoad>& loads;  ///< on the recorded person's feet, which tell steps of a stair
};

struct PlantedFeet {
  RecordedPositions positions;  ///< of the body, at the recorded times
  /// By foot, at these times: m, height of the floor or step under it, in the body's world.
  std::map<std::string, std::vector<double>> floors;
};

/// Positions of the body, in its own system, at the times of `recorded` (of the sized system with the same
/// coordinates): see motion_transfer.hpp. Errors: as MarkerFit.
Result<PlantedFeet> planted_positions(const System& sized, const RecordedPositions& recorded,
                                      const System& body, const FeetOnGround& feet);

}  // namespace borelli
