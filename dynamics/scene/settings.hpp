// How a scene is to be simulated.
#pragma once

#include <string>

namespace borelli {

/// How constraints are kept against the drift of integration.
enum class ConstraintTreatment {
  projection,  ///< position and velocity are put back after each accepted step (the default)
  baumgarte    ///< L a + E + 2 alpha dh/dt + beta^2 h = 0: restoring accelerations, constant gains
};

/// Which equations of motion are solved. Both give the same numbers but for rounding.
enum class Equations {
  recursive,  ///< recursions along the tree (recursive.hpp), O(n) without constraints (the default)
  lagrange    ///< the paper's hierarchical scan (lagrange.hpp)
};

/// How several contacts that close at one moment share the shock.
enum class ImpactLaw {
  sequential,   ///< one pair after the other, the fastest first, until all part: a row of balls passes it on
  simultaneous  ///< all at once
};

/// What a restitution below 1 means.
enum class RestitutionLaw {
  newton,  ///< of velocities: they part with e times the speed at which they met
  poisson  ///< of impulses: what drives them apart is e times what brought them to rest
};

struct SimulationSettings {
  double end_time = 1;                  ///< s; the state's own time is the start
  std::string method = "rk4_adaptive";  ///< of integrator_names()
  double step = 0.01;                   ///< s; the fixed step, or the first one tried by an adaptive method
  double tolerance = 1e-6;  ///< adaptive methods: largest error per step and coordinate (see README.md)
  /// Of positions and velocities on their scales (see accuracy.hpp), 1e-11 to 0.1: method and tolerance are
  /// then chosen by the program, whatever is said above. 0: not asked for.
  double accuracy = 0;
  /// Of a run to an accuracy: whether it is run anew at a tenth of its tolerance, and what the two differ by
  /// counts as the error. Else a coarser run estimates it (see accuracy.hpp).
  bool verify = false;
  double spectral_radius =
      0.8;  ///< of generalized_alpha, for infinitely stiff modes: 0 kills them, 1 keeps them
  double output_interval = 0;  ///< s between rows of the trajectory; 0: every accepted step
  Equations equations = Equations::recursive;
  ConstraintTreatment constraints = ConstraintTreatment::projection;
  double baumgarte_alpha = 5;  ///< 1/s
  double baumgarte_beta = 5;   ///< 1/s; alpha = beta is critical damping
  /// The certificate's thresholds. Relative to the energy turned over (see Certificate); 0: chosen from the
  /// method and tolerance.
  double energy_threshold = 0;
  ImpactLaw impacts = ImpactLaw::sequential;
  RestitutionLaw restitution = RestitutionLaw::newton;
  /// m/s or rad/s: contacts that meet more slowly do not rebound (so rebounds that would follow each other
  /// without end come to rest), and those that part no faster stay together.
  double rest_speed = 1e-6;
  /// What overlaps at the start is put apart by the least move (put_apart.hpp); else it is refused.
  bool put_apart = false;
};

}  // namespace borelli
