#include "dynamics/methods/explicit_runge_kutta.hpp"

namespace borelli {

Attempt ExplicitRungeKutta::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                                    const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  const int stages = tableau_.stages;
  for (int i = 1; i < stages; ++i) {
    stage_ = y;
    for (int j = 0; j < i; ++j) {
      const double c = tableau_.coupling[i * stages + j];
      if (c != 0) stage_ += h * c * (j == 0 ? dy : k_[j]);
    }
    if (!flow.derivative(t + tableau_.nodes[i] * h, stage_, k_[i]))
      return {.evaluated = false, .next_step = h};
  }
  out = y;
  for (int i = 0; i < stages; ++i)
    if (tableau_.weights[i] != 0) out += h * tableau_.weights[i] * (i == 0 ? dy : k_[i]);
  return {.next_step = h};
}

const Tableau& euler() {
  static constexpr double nodes[] = {0}, weights[] = {1}, coupling[] = {0};
  static constexpr Tableau tableau{1, 1, nodes, weights, coupling};
  return tableau;
}

const Tableau& midpoint() {
  static constexpr double nodes[] = {0, 0.5}, weights[] = {0, 1};
  static constexpr double coupling[] = {0, 0, 0.5, 0};
  static constexpr Tableau tableau{2, 2, nodes, weights, coupling};
  return tableau;
}

const Tableau& classical_runge_kutta() {
  static constexpr double nodes[] = {0, 0.5, 0.5, 1};
  static constexpr double weights[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  static constexpr double coupling[] = {0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0};
  static constexpr Tableau tableau{4, 4, nodes, weights, coupling};
  return tableau;
}

}  // namespace borelli
