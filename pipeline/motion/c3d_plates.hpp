// The force plates of a C3D file: its FORCE_PLATFORM group and the analog channels that it names.
// Source: C3D user guide, "The FORCE_PLATFORM group", www.c3d.org.
#pragma once

#include <string>
#include <vector>

#include "pipeline/motion/c3d_file.hpp"
#include "pipeline/motion/c3d_layout.hpp"
#include "pipeline/motion/c3d_parameters.hpp"
#include "pipeline/motion/force_plate.hpp"

namespace borelli {

/// All plates of FORCE_PLATFORM:USED that have a type of 1 to 4, corners of a rectangle and channels of their own;
/// a warning names each other one and the reason. `metres`: of one POINT:UNITS.
///
/// Units of the channels: N and N m as ANALOG:UNITS names them; where it names none of these, N and
/// N x POINT:UNITS. Type 4 is multiplied by CAL_MATRIX, which is stored by columns and gives N and N x POINT:UNITS.
std::vector<ForcePlate> c3d_plates(const C3dParameters& parameters, const C3dLayout& layout,
                                   const std::vector<AnalogChannel>& analog, double metres,
                                   std::vector<std::string>& warnings);

}  // namespace borelli
