// How a scene is to be simulated.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace borelli {

/// How constraints are stabilised against drift.
enum class ConstraintTreatment {
  projection,  ///< projects position and velocity after each accepted step (the default)
  baumgarte    ///< L a + E + 2 alpha dh/dt + beta^2 h = 0: restoring accelerations, constant gains
};

/// Which equations of motion are solved. Both agree to rounding.
enum class Equations {
  recursive,  ///< recursions along the tree (recursive.hpp), O(n) without constraints (the default)
  lagrange    ///< the paper's hierarchical scan (lagrange.hpp)
};

/// How several simultaneous impacts are resolved.
enum class ImpactLaw {
  sequential,   ///< one contact after the other, fastest first, until all separate (Newton's cradle)
  simultaneous  ///< all at once
};

/// The meaning of a coefficient of restitution e < 1.
enum class RestitutionLaw {
  newton,  ///< separation speed = e times approach speed
  poisson  ///< expansion impulse = e times compression impulse
};

struct SimulationSettings {
  double end_time = 1;                  ///< s; the run starts at the time of the state
  std::string method = "rk4_adaptive";  ///< one of integrator_names()
  double step = 0.01;                   ///< s; the fixed step, or the first one tried by an adaptive method
  double tolerance = 1e-6;  ///< adaptive methods: largest error per step and coordinate (see README.md)
  /// Wanted accuracy of positions and velocities relative to their scales (see accuracy.hpp), 1e-11 to 0.1.
  /// The program then chooses method and tolerance and ignores those given here. 0: none wanted.
  double accuracy = 0;
  /// With an accuracy: repeats the run at a tenth of its tolerance and takes the difference as the error.
  /// Otherwise a coarser run estimates the error (see accuracy.hpp).
  bool verify = false;
  double spectral_radius =
      0.8;  ///< generalized_alpha: for infinitely stiff modes; 0 damps them at once, 1 keeps them
  double output_interval = 0;  ///< s between rows of the trajectory; 0: every accepted step
  Equations equations = Equations::recursive;
  ConstraintTreatment constraints = ConstraintTreatment::projection;
  double baumgarte_alpha = 5;  ///< 1/s
  double baumgarte_beta = 5;   ///< 1/s; alpha = beta is critical damping
  /// The largest energy drift that the certificate trusts, relative to the energy turnover (see Certificate).
  /// 0: chosen from method and tolerance.
  double energy_threshold = 0;
  ImpactLaw impacts = ImpactLaw::sequential;
  RestitutionLaw restitution = RestitutionLaw::newton;
  /// m/s or rad/s. Contacts that close more slowly do not rebound, so that infinite sequences of rebounds
  /// end. Contacts that separate no faster stay closed.
  double rest_speed = 1e-6;
  /// Separates contacts that overlap at the start by the smallest displacement (put_apart.hpp). Otherwise an
  /// overlap is an error.
  bool put_apart = false;

  /// Visits every setting by its key in scene files, in their order there: visit(key, value), or for a choice
  /// visit(key, value, words), where words[int(value)] is the value's word. Writing a scene and the signature
  /// of a checkpoint use this list, so a new setting belongs into it.
  template <class Settings, class Visit>
  static void fields(Settings& s, Visit&& visit) {
    using Words = std::array<std::string_view, 2>;
    visit("end_time", s.end_time);
    visit("step", s.step);
    visit("output_interval", s.output_interval);
    visit("accuracy", s.accuracy);
    visit("method", s.method);
    visit("tolerance", s.tolerance);
    visit("equations", s.equations, Words{"recursive", "lagrange"});
    visit("verify", s.verify);
    visit("spectral_radius", s.spectral_radius);
    visit("constraints", s.constraints, Words{"projection", "baumgarte"});
    visit("baumgarte_alpha", s.baumgarte_alpha);
    visit("baumgarte_beta", s.baumgarte_beta);
    visit("impacts", s.impacts, Words{"sequential", "simultaneous"});
    visit("restitution", s.restitution, Words{"newton", "poisson"});
    visit("rest_speed", s.rest_speed);
    visit("overlaps", s.put_apart, Words{"refuse", "put_apart"});
    visit("energy_threshold", s.energy_threshold);
  }
};

}  // namespace borelli
