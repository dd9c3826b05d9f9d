// The file form of a checkpoint: the signature of its run, the run's numbers, and a checksum.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "dynamics/numbers/keeper.hpp"
#include "dynamics/system/system.hpp"
#include "error/error.hpp"

namespace borelli {

/// Identifies a run by the system's sizes, the state at its start and all its settings.
std::string run_signature(const System& system, const State& start, const SimulationSettings& settings);

/// A checkpoint of the run with that signature. `keep` saves the run's numbers.
std::string write_checkpoint(std::string signature, const std::function<void(Keeper&)>& keep);

/// Restores what `keep` saved. Fails if the checkpoint is damaged, or belongs to another run or program. The
/// run is undefined after a failure.
Result<void> read_checkpoint(std::string_view checkpoint, const std::string& signature,
                             const std::function<void(Keeper&)>& keep);

}  // namespace borelli
