// The force plates of a C3D file: its FORCE_PLATFORM group and the analog channels that it names.
// Source: C3D user guide, "The FORCE_PLATFORM group", www.c3d.org.
#pragma once

#include <string>
#include <vector>

#include "pipeline/recordings/c3d_file.hpp"
#include "pipeline/recordings/c3d_layout.hpp"
#include "pipeline/recordings/c3d_parameters.hpp"
#include "pipeline/recordings/force_plate.hpp"

namespace borelli {

/// The plates of FORCE_PLATFORM:USED with a type of 1 to 4, rectangular corners and channels of their own.
/// Each plate that is left out gets a warning with the reason. `metres`: length of one POINT:UNITS, m.
///
/// Channels have the units of ANALOG:UNITS. Where these are missing or unknown, forces are in N, positions in
/// POINT:UNITS and moments in N x POINT:UNITS. Channels of type 4 are multiplied by CAL_MATRIX (stored by
/// columns), which gives N and N x POINT:UNITS.
std::vector<ForcePlate> c3d_plates(const C3dParameters& parameters, const C3dLayout& layout,
                                   const std::vector<AnalogChannel>& analog, double metres,
                                   std::vector<std::string>& warnings);

}  // namespace borelli
