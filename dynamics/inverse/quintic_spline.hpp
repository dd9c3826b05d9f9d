// Natural quintic splines: the interpolant with four continuous derivatives that has the least integral of
// its squared third derivative; its third and fourth derivatives vanish at both ends (Woltring, A Fortran
// package for generalized, cross-validatory spline smoothing and differentiation, Advances in Engineering
// Software 8, 1986, at smoothing 0). Motion analysis differentiates measured coordinates twice with it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "error/error.hpp"

namespace borelli {

class QuinticSpline {
 public:
  /// Through `values` (#times by #columns) at increasing `times`, s. Errors: fewer than three times, times
  /// that do not increase, values that are not finite.
  static Result<QuinticSpline> through(std::vector<double> times, Eigen::MatrixXd values);

  /// Values, first and second derivatives of all columns at t. Beyond the ends the end pieces continue.
  void at(double t, Eigen::VectorXd& value, Eigen::VectorXd& rate, Eigen::VectorXd& second) const;

  const std::vector<double>& times() const { return times_; }
  Eigen::Index columns() const { return values_.cols(); }

 private:
  void fit();
  std::vector<double> times_;
  Eigen::MatrixXd values_, rates_, seconds_;  ///< at the times: values, first and second derivatives
};

}  // namespace borelli
