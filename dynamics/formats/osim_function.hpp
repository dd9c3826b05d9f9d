// OpenSim's functions of one variable.
#pragma once

#include "dynamics/formats/xml_element.hpp"
#include "dynamics/numbers/time_function.hpp"

namespace borelli {

/// The function that an element holds: its child of a function's name, or that of its <function>. Null: none.
const XmlElement* osim_function_in(const XmlElement& holder);

/// Reads Constant, LinearFunction, PolynomialFunction (highest power first), Sine, SimmSpline, cubic
/// GCVSpline without smoothing, PiecewiseLinearFunction on one line, and MultiplierFunction of these.
/// NaturalCubicSpline and natCubicSpline are older names of SimmSpline: OpenSim renames them
/// (RegisterTypes_osimCommon.cpp). Throws XmlRefusal; other functions are refused by name.
TimeFunction read_osim_function(const XmlElement& function);

/// Whether a function is c0 + c1 x.
bool is_line(const TimeFunction& function);
/// Whether a function is the same everywhere.
bool is_constant(const TimeFunction& function);

}  // namespace borelli
