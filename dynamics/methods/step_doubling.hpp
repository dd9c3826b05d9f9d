// Adaptive steps by doubling: each step is made once as a whole and once in two halves. The difference
// controls the step; 1/15 of it (at order 4) is added to the result (local extrapolation). Press et al.,
// Numerical Recipes, section 16.2: the paper's adaptive fourth-order Runge-Kutta method.
#pragma once

#include "dynamics/methods/explicit_runge_kutta.hpp"

namespace borelli {

class StepDoubling : public Integrator {
 public:
  StepDoubling(const Tableau& tableau, double tolerance) : method_(tableau), tolerance_(tolerance) {}
  int order() const override { return method_.order() + 1; }  ///< of the extrapolated result
  bool adaptive() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;

 private:
  ExplicitRungeKutta method_;
  double tolerance_;
  Eigen::VectorXd whole_, middle_, slope_;
};

}  // namespace borelli
