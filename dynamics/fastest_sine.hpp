// The fastest oscillation in time that a scene's drives, efforts and constraints prescribe. A method that
// steps over whole periods of it sees other values than the scene gives (aliasing) and cannot notice.
#pragma once

#include <optional>
#include <string>

#include "dynamics/system.hpp"

namespace borelli {

struct FastestSine {
  std::string name;   ///< what it moves, e.g. "effort 'push'"
  double period = 0;  ///< s
};

/// The Sine of the shortest period among the functions of time; none: no Sine of any amplitude. What a
/// user's own C++ (FunctionConstraint, OwnEffort) does in time is not known.
std::optional<FastestSine> fastest_sine(const System& system, const Parameters& parameters);

/// The longest step that follows a Sine, in parts of its period. With eight steps to a period classical
/// Runge-Kutta samples it sixteen times, and step doubling thirty-two times: w h is below 0.8 (0.4 for the
/// half steps), where the methods' series in w h converge fast and the difference of whole and half steps is
/// an estimate of the error; one step per period would show both the same value.
inline constexpr double longest_step_in_periods = 1.0 / 8;

}  // namespace borelli
