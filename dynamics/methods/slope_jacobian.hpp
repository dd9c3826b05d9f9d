// df/dy of a flow by finite differences, for Newton's method in implicit integrators.
#pragma once

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// How many of y's components f depends on: positions and velocities, or all if the flow does not distinguish
/// them. The remaining components (work) are quadratures and do not affect f.
inline Eigen::Index acting_components(const Flow& flow) {
  return flow.positions() > 0 ? 2 * flow.positions() : flow.size();
}

/// J <- derivatives of f's first J.rows() components by y's first J.cols() components at (t, y), given dy =
/// f(t, y). Forward differences of 1e-7 of the component's scale. `moved` and `slope` are scratch of y's
/// size. Returns false if f could not be evaluated.
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
