// Plain differential equations for tests of integrators.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "dynamics/methods/integrator.hpp"

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

/// Integrates from 0 to `end` in equal steps.
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

inline FunctionFlow bernoulli() {  // y = 1 / (2 + sin t)
  return {
      1, [](double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) { dy[0] = -y[0] * y[0] * std::cos(t); }};
}

/// Integrates from 0 to `end` in the method's own steps, starting with 0.1. Returns the number of steps.
inline int advance(FunctionFlow& flow, Integrator& method, Eigen::VectorXd& y, double end) {
  Eigen::VectorXd dy(y.size()), out(y.size());
  double t = 0, h = 0.1;
  int steps = 0;
  while (t < end) {
    h = std::min(h, end - t);
    flow.derivative(t, y, dy);
    const Attempt attempt = method.attempt(flow, t, h, y, dy, out);
    if (attempt.accepted) t += h, y = out, ++steps;
    h = attempt.next_step;
  }
  return steps;
}

/// Two bodies on hardening springs, whose slopes can be computed in lanes. Undefined when the first is beyond
/// 3.
struct SpringsInLanes : FunctionFlow {
  SpringsInLanes() : FunctionFlow(4, function) {}
  static void function(double, const Eigen::VectorXd& y, Eigen::VectorXd& dy) {
    dy << y[2], y[3], -y[0] - y[0] * y[0] * y[0] + y[1], -2 * y[1] + y[0];
  }
  bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) override {
    return FunctionFlow::derivative(t, y, dy) && y[0] <= 3;
  }
  bool has_lanes() override { return in_lanes; }
  bool derivatives(const Eigen::VectorX<Quad>& y, int states, Eigen::VectorX<Quad>& dy) override {
    return each(y, states, dy);
  }
  bool derivatives(const Eigen::VectorX<Lanes>& y, int states, Eigen::VectorX<Lanes>& dy) override {
    return each(y, states, dy);
  }
  template <class T>
  bool each(const Eigen::VectorX<T>& y, int states, Eigen::VectorX<T>& dy) {
    evaluations += states;
    ++calls;
    Eigen::VectorXd one(4), slope(4);
    for (int lane = 0; lane < T::count; ++lane) {
      for (int c = 0; c < 4; ++c) one[c] = y[c][lane];
      if (!(one[0] <= 3)) return false;
      function(0, one, slope);
      for (int c = 0; c < 4; ++c) dy[c].set(lane, slope[c]);
    }
    return true;
  }
  bool in_lanes = true;
  int calls = 0;
};

}  // namespace borelli::test
