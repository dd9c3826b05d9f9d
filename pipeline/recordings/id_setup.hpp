// OpenSim's set-up of inverse dynamics: the motion, the external loads, and how the motion is smoothed.
//
// Source: opensim-core, OpenSim/Tools/InverseDynamicsTool.cpp and DynamicsTool.cpp, whose default values are
// taken here.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/formats/unread.hpp"
#include "error/error.hpp"

namespace borelli {

/// Paths are relative to the set-up's own folder, joined with it; empty where none is given.
struct InverseDynamicsSetup {
  std::string name;
  std::filesystem::path model_file, coordinates_file, external_loads_file, results_directory;
  std::filesystem::path output_gen_force_file = "inverse_dynamics.sto";  ///< within results_directory
  std::pair<double, double> time_range;                                  ///< s; infinite: as far as the data
  std::vector<std::string> forces_to_exclude;
  std::optional<double> lowpass_cutoff;  ///< Hz; empty: the coordinates are not filtered
  NotModelled not_modelled;              ///< elements that were not read
};

/// Reads an <InverseDynamicsTool> file, with or without <OpenSimDocument> around it. A cutoff frequency below
/// zero means no filter, as in OpenSim. Errors, with their line: another file; words that are no numbers; a
/// cutoff frequency of zero; a range that ends before it starts.
Result<InverseDynamicsSetup> read_id_setup(const std::filesystem::path& path);

}  // namespace borelli
