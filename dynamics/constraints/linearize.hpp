// Small deviations from a steady state: the state matrix, its eigenvalues and modes.
#pragma once

#include <complex>

#include "dynamics/system/system.hpp"

namespace borelli {

/// One deviation shape exp(eigenvalue t); of a conjugate pair the one with the positive frequency.
struct Mode {
  std::complex<double> eigenvalue;  ///< 1/s
  double frequency = 0;      ///< Hz: |eigenvalue| / (2 pi), as without damping; 0: it does not oscillate
  double damping_ratio = 0;  ///< -real part / |eigenvalue|; 1: it only decays, -1: it only grows
  Eigen::VectorXcd
      shape;  ///< nv: the deviations of the positions in the units of the velocities (a ball's: the
              ///< small turn in its own axes); the largest, by the coordinates' lengths, is 1
};

enum class Stability { stable, neutral, unstable };

/// d/dt (y, z) = state_matrix (y, z): the deviation of the positions is basis y, that of the velocities basis
/// z. The columns of the basis span what the constraints leave free (nv x m).
struct Linearization {
  Rows basis;               ///< nv x m
  Rows state_matrix;        ///< 2m x 2m
  std::vector<Mode> modes;  ///< by their frequency's imaginary part, slow ones first
  /// Stable: all deviations die out. Neutral: none grows to first order (an undamped oscillation, a direction
  /// without restoring effort). Real parts below 1e-6 of the largest eigenvalue count as zero: two equal
  /// zeros are known to the root of rounding only.
  Stability stability = Stability::neutral;
};

/// At a state that is steady: an equilibrium, or a rotation along which the equations do not change (a top
/// that sleeps). By the exact derivatives of the accelerations (derivatives.hpp) on the tangent space of the
/// constraints. Fails, by name, where the state is not steady, where a constrained one is not at rest, and
/// where there are contacts.
Result<Linearization> linearize(const System& system, const State& state);

const char* word_for(Stability stability);

}  // namespace borelli
