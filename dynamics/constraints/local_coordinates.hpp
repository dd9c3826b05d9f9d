// Local coordinates of the positions around a state. Integrators and corrections then work on plain vectors
// of nv numbers: q(x) adds x to lengths and angles, and rotates a ball by the rotation vector x in its own
// axes. Quaternions stay unit by construction. The rate of x is exact, so a method keeps its full order in
// orientation too (Munthe-Kaas, Runge-Kutta methods on Lie groups, BIT 38, 1998).
#pragma once

#include "dynamics/numbers/lanes.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

/// q <- the positions at local coordinates x (nv) around q0 (both nq; q may be q0).
void from_local_coordinates(const System& system, const double* q0, const double* x, double* q);
void from_local_coordinates(const System& system, const Lanes* q0, const Lanes* x, Lanes* q);
void from_local_coordinates(const System& system, const Quad* q0, const Quad* x, Quad* q);

/// rate <- dx/dt at x for the velocities v (all nv). Singular if a ball has turned by 2 pi from q0.
void local_rate(const System& system, const double* x, const double* v, double* rate);
void local_rate(const System& system, const Lanes* x, const Lanes* v, Lanes* rate);
void local_rate(const System& system, const Quad* x, const Quad* v, Quad* rate);

}  // namespace borelli
