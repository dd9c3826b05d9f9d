// Plain differential equations for tests of integrators.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "dynamics/integrator.hpp"

namespace borelli::test {

/// y' = f(t, y), which cannot be evaluated after `last`.
class FunctionFlow : public Flow {
 public:
  using Function = std::function<void(double, const Eigen::VectorXd&, Eigen::VectorXd&)>;
  FunctionFlow(Eigen::Index size, Function f, double last = std::numeric_limits<double>::infinity())
      : f_(std::move(f)), scale_(Eigen::VectorXd::Ones(size)), last_(last) {}
  Eigen::Index size() const override { return scale_.size(); }
  bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) override {
    ++evaluations;
    dy.setZero(size());
    f_(t, y, dy);
    return t <= last_;
  }
  const Eigen::VectorXd& error_scale() const override { return scale_; }
  int evaluations = 0;

 private:
  Function f_;
  Eigen::VectorXd scale_;
  double last_;
};

/// From 0 to `end` in equal steps.
inline Eigen::VectorXd integrate(Flow& flow, Integrator& method, Eigen::VectorXd y, double end, int steps) {
  Eigen::VectorXd dy(y.size()), out(y.size());
  for (int i = 0; i < steps; ++i) {
    const double t = end * i / steps;
    flow.derivative(t, y, dy);
    EXPECT_TRUE(method.attempt(flow, t, end / steps, y, dy, out).evaluated);
    y = out;
  }
  return y;
}

}  // namespace borelli::test
