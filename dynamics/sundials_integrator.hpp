// A method for stiff scenes from SUNDIALS (Hindmarsh et al., ACM TOMS 31, 2005): CVODE's backward
// differentiation formulas of order 1 to 5. It chooses order and steps itself, with dense linear algebra and
// derivatives by differences.
#pragma once

#include <memory>

#include "dynamics/integrator.hpp"

namespace borelli {

/// Keeps the history of several steps: the chart must hold over them, and no projection may come between.
class CvodeBdf : public Integrator {
 public:
  explicit CvodeBdf(double tolerance);
  ~CvodeBdf() override;
  int order() const override { return 5; }  ///< at most
  bool adaptive() const override { return true; }
  bool keeps_history() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  /// That of the formula in use, by its own interpolation.
  int dense_order() const override { return 5; }
  bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                     const Eigen::VectorXd& out) override;
  void interpolate(double theta, Eigen::VectorXd& y) const override;
  void reset() override;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
  double tolerance_;
  double from_ = 0, made_ = 0;  ///< the last step
};

}  // namespace borelli
