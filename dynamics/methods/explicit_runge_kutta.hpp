// Explicit Runge-Kutta methods with fixed steps, given by their tableaus: Euler, midpoint rule (order 2) and
// the classical method of order 4 (Press et al., Numerical Recipes, section 16.1).
#pragma once

#include <span>

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// A Butcher tableau: k_i is the slope at t + nodes[i] h, y + h sum_j coupling[i][j] k_j; the step adds h sum
/// weights[i] k_i.
struct Tableau {
  int order;
  int stages;
  std::span<const double> nodes, weights;
  std::span<const double> coupling;  ///< rows of `stages` numbers
};

class ExplicitRungeKutta : public Integrator {
 public:
  explicit ExplicitRungeKutta(const Tableau& tableau) : tableau_(tableau), k_(tableau.stages) {}
  int order() const override { return tableau_.order; }
  bool adaptive() const override { return false; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;

 private:
  Tableau tableau_;
  std::vector<Eigen::VectorXd> k_;
  Eigen::VectorXd stage_;
};

const Tableau& euler();
const Tableau& midpoint();
const Tableau& classical_runge_kutta();

}  // namespace borelli
