// The rows of a trajectory as they come.
#pragma once

#include "dynamics/equations.hpp"
#include "dynamics/work.hpp"

namespace borelli {

class Recorder {
 public:
  explicit Recorder(const System& system);

  /// A row: a state whose equations are solved in `w`.
  void record(const State& state, const Workspace& w, const Work& work);
  /// An accepted step of h from time t, s.
  void record_step(double t, double h);
  /// What contacts did in an accepted step of h (s) by impulses, N s: three numbers each, along the normal
  /// and the two across. The rows after it hold their mean forces since the row before, and their modes by
  /// these.
  void record_impulses(const Eigen::VectorXd& impulses, double h);
  Trajectory finish(Certificate certificate);

  template <class Keeper>
  void keep(Keeper& k) {
    k(out_.times, out_.poses, out_.kinetic, out_.potential, out_.work, out_.step_times, out_.step_sizes,
      contact_modes_, contact_forces_, impulses_, forces_, impulses_time_, q_, v_, a_, multipliers_,
      driven_efforts_, driven_positions_, gravity_centre_, linear_momentum_, angular_momentum_);
  }

 private:
  void record_contacts(const Workspace& w);

  const System& system_;
  Trajectory out_;
  std::vector<double> contact_modes_, contact_forces_;
  Eigen::VectorXd impulses_, forces_;  // of contacts that act by impulses: since the last row, and at it
  double impulses_time_ = 0;           // s, that these took
  std::vector<double> q_, v_, a_, multipliers_, driven_efforts_, driven_positions_;
  std::vector<double> gravity_centre_, linear_momentum_, angular_momentum_;
};

}  // namespace borelli
