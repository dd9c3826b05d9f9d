#include "dynamics/constraint_function.hpp"

#include "dynamics/scan.hpp"

namespace borelli {

void FunctionConstraint::evaluate(ConstraintScan& scan) const {
  auto& [x, rate, h] = scan.scratch();
  const int scalars = int(coordinates.size());
  for (int i = 0; i < scalars; ++i) {
    x[i] = scan.position(i);
    rate[i] = scan.rate(i);
  }
  for (int i = 0; i < int(points.size()); ++i) {
    const MovingPoint point = scan.point(i, points[i].point);
    x.segment<3>(scalars + 3 * i) = point.p;
    rate.segment<3>(scalars + 3 * i) = point.v;
  }
  h.value = h.rate = h.acceleration = 0;
  h.gradient.setZero();
  h.gradient_rate.setZero();
  h.hessian.setZero();
  function(scan.time(), x, h);
  for (int i = 0; i < scalars; ++i) scan.coordinate(0, i, h.gradient[i]);
  for (int i = 0; i < int(points.size()); ++i)
    scan.along(0, i, x.segment<3>(scalars + 3 * i), h.gradient.segment<3>(scalars + 3 * i));
  double curvature = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) curvature += rate[i] * h.hessian.row(i).dot(rate);
  scan.residual(0, h.value, h.rate, curvature + 2 * h.gradient_rate.dot(rate) + h.acceleration);
}

}  // namespace borelli
