// A local chart of the positions around a state, so that integrators and corrections see plain vectors of nv
// numbers: q(x) adds x to lengths and angles and turns a ball by the rotation vector x about its own axes.
// Quaternions stay unit by construction, and the rate of x is exact, so a method keeps its full order in
// orientation too (Munthe-Kaas, Runge-Kutta methods on Lie groups, BIT 38, 1998).
#pragma once

#include "dynamics/system.hpp"

namespace borelli {

template <int N>
class LanesOf;

/// q <- the positions at chart coordinates x (nv) around q0 (both nq; q may be q0).
void from_chart(const System& system, const double* q0, const double* x, double* q);
void from_chart(const System& system, const LanesOf<8>* q0, const LanesOf<8>* x, LanesOf<8>* q);
void from_chart(const System& system, const LanesOf<4>* q0, const LanesOf<4>* x, LanesOf<4>* q);

/// rate <- dx/dt at x for the velocities v (all nv). Breaks down where a ball has turned by 2 pi from q0.
void chart_rate(const System& system, const double* x, const double* v, double* rate);
void chart_rate(const System& system, const LanesOf<8>* x, const LanesOf<8>* v, LanesOf<8>* rate);
void chart_rate(const System& system, const LanesOf<4>* x, const LanesOf<4>* v, LanesOf<4>* rate);

}  // namespace borelli
