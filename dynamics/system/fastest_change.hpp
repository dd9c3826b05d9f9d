// The fastest change in time that the drives, efforts and constraints of a scene prescribe. Steps that span
// whole waves of it alias it unnoticed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/system/system.hpp"

namespace borelli {

struct FastestChange {
  std::string name;   ///< what the function moves, e.g. "effort 'push'"
  std::string wave;   ///< the meaning of period: "period", or "shortest wave (a polynomial of degree 6)"
  double period = 0;  ///< s
};

/// The shortest period of the functions of time in a run of `span` seconds; none: nothing changes.
/// - Sine: its period, for any amplitude.
/// - Polynomial of degree d: 2 span / d. It has at most d zeros, and its variation between closer zeros is
///   small beside that elsewhere in the run.
/// - Table: four times its shortest interval, the width of the response of the spline to one outlier. Without
///   `tables` they are left out: steps that end at the knots (knots.hpp) resolve each piece, and a piece has
///   no waves.
/// Changes in time inside user C++ (FunctionConstraint, OwnEffort) are unknown.
std::optional<FastestChange> fastest_change(const System& system, const Parameters& parameters, double span,
                                            bool tables);

/// Per independent group: whether its work must be as accurate as its motion, because the motion says too
/// little about it. This holds if drives or constraints move it in time, or a user-defined constraint may. It
/// also holds for a limit spring with losses, which do not end smoothly where a slack spring leaves its
/// bound.
std::vector<char> groups_of_counted_work(const System& system, const Parameters& parameters);

/// The longest step that resolves the change, in periods. With eight steps to a period classical Runge-Kutta
/// samples it sixteen times, and step doubling thirty-two times. Then w h is below 0.8 (0.4 for the half
/// steps): the series of the methods in w h converge fast, and the difference of whole and half steps
/// estimates the error. With one step per period both would sample the same value. A run samples a polynomial
/// of degree d at more than 4 d times: it cannot vanish at all of them.
inline constexpr double longest_step_in_periods = 1.0 / 8;

}  // namespace borelli
