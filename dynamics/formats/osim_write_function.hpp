// Functions of one variable as those of OpenSim.
#pragma once

#include <string>

#include "dynamics/formats/xml_text.hpp"
#include "dynamics/numbers/time_function.hpp"

namespace borelli {

/// Why OpenSim cannot hold a function exactly: "follow a periodic spline, which OpenSim does not have".
/// Empty: it can.
std::string osim_function_complaint(const TimeFunction& function);

/// Adds a function to its holder: Constant, LinearFunction, PolynomialFunction, Sine, SimmSpline (Forsythe's
/// end conditions) or GCVSpline without smoothing (natural ones). Precondition: no complaint.
void write_osim_function(XmlNode& holder, const TimeFunction& function, const std::string& name);

}  // namespace borelli
