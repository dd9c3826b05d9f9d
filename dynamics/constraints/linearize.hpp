// Linearisation about a steady state: state matrix, eigenvalues and modes.
#pragma once

#include <complex>

#include "dynamics/system/system.hpp"

namespace borelli {

/// One mode shape times exp(eigenvalue t); of a conjugate pair, the one with positive frequency.
struct Mode {
  std::complex<double> eigenvalue;  ///< 1/s
  double frequency = 0;             ///< undamped frequency |eigenvalue| / (2 pi), Hz; 0: no oscillation
  double damping_ratio = 0;         ///< -real part / |eigenvalue|; 1: it only decays, -1: it only grows
  Eigen::VectorXcd
      shape;  ///< nv: position deviations in the units of the velocities (for a ball, a small rotation in its
              ///< own axes), scaled so that the largest, relative to its coordinate's length, is 1
};

enum class Stability { stable, neutral, unstable };

/// d/dt (y, z) = state_matrix (y, z), where basis y is the deviation of the positions and basis z that of the
/// velocities. The columns of the basis (nv x m) span the directions that the constraints leave free.
struct Linearization {
  Rows basis;               ///< nv x m
  Rows state_matrix;        ///< 2m x 2m
  std::vector<Mode> modes;  ///< ascending by the eigenvalue's imaginary part
  /// Stable: all deviations decay. Neutral: none grows to first order (an undamped oscillation, a direction
  /// without stiffness). Real parts below 1e-6 of the largest eigenvalue count as zero, because a double
  /// eigenvalue zero is accurate only to the root of rounding.
  Stability stability = Stability::neutral;
};

/// Linearises about a steady state: an equilibrium, or a rotation along which the equations do not change (a
/// sleeping top). Uses the exact derivatives of the accelerations (derivatives.hpp) on the tangent space of
/// the constraints. Fails by name if the state is not steady or violates a constraint; if the equations of
/// motion at this state change with time; if the scene has constraints and the state moves; if the scene has
/// contacts.
Result<Linearization> linearize(const System& system, const State& state);

const char* word_for(Stability stability);

}  // namespace borelli
