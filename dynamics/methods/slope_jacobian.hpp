// df/dy of a flow by differences: for methods that solve implicit equations by Newton's method.
#pragma once

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// How many of y's components f depends on: positions and velocities, or all where a flow does not tell them
/// apart. What is integrated beside them (work) has no effect on f.
inline Eigen::Index acting_components(const Flow& flow) {
  return flow.positions() > 0 ? 2 * flow.positions() : flow.size();
}

/// J <- the derivatives of f's first J.rows() components by y's first J.cols() at (t, y), where dy = f(t, y);
/// each by a difference of 1e-7 of the component's scale. `moved` and `slope` are scratch, sized as y. False:
/// f could not be evaluated.
template <class Matrix>
bool slope_jacobian(Flow& flow, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                    Eigen::VectorXd& moved, Eigen::VectorXd& slope, Matrix& J) {
  moved = y;
  slope.resize(y.size());
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    moved[k] = y[k] + 1e-7 * flow.error_scale()[k];
    if (!flow.derivative(t, moved, slope)) return false;
    J.col(k) = (slope.head(J.rows()) - dy.head(J.rows())) / (moved[k] - y[k]);
    moved[k] = y[k];
  }
  return true;
}

}  // namespace borelli
