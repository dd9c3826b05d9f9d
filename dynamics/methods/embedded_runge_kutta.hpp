// Embedded explicit Runge-Kutta pairs with error estimate, step control and their own dense output:
// Dormand-Prince 5(4) and DOP853. Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (second
// edition), sections II.4 to II.6.
#pragma once

#include <span>

#include "dynamics/methods/explicit_runge_kutta.hpp"
#include "dynamics/methods/step_control.hpp"

namespace borelli {

/// A pair with its dense output. The stages are numbered in this order: those of the step, the slope at the
/// step's end (the first stage of the next step), those that only dense output needs.
struct EmbeddedTableau {
  Tableau step;
  std::span<const double> error;  ///< weights of the error estimate, over the step's stages and the end slope
  /// Weights of a coarser estimate e3 that damps the first: |e|^2 / sqrt(|e|^2 + 0.01 |e3|^2). Empty: none.
  std::span<const double> coarse_error;
  int dense_order;
  int dense_stages;  ///< stages beyond the step's and the end slope
  std::span<const double> dense_nodes;
  std::span<const double> dense_coupling;  ///< rows over all stages
  /// Rows over all stages: the terms of dense output after the first four, which are those of Hermite's
  /// cubic.
  std::span<const double> dense_weights;
  StepControl::Limits limits;
  double stability;  ///< stability bound on the step times the slope's rate of change
  int all_stages() const { return step.stages + 1 + dense_stages; }
};

class EmbeddedRungeKutta : public Integrator {
 public:
  EmbeddedRungeKutta(const EmbeddedTableau& tableau, double tolerance);
  int order() const override { return tableau_.step.order; }
  bool adaptive() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  double first_step(Flow& flow, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& dy) override;
  int dense_order() const override { return tableau_.dense_order; }
  bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                     const Eigen::VectorXd& out) override;
  void interpolate(double theta, Eigen::VectorXd& y) const override;
  bool keep(Keeper& k) override {
    k(control_, last_known_, last_gap_, last_step_, last_slope_, stiff_steps_, other_steps_, stiff_);
    return true;
  }
  void reset() override;
  bool stiff() const override { return stiff_; }

 private:
  bool evaluate(Flow& flow, double t, double h, const Eigen::VectorXd& y, double node, const double* coupling,
                int stages, Eigen::VectorXd& slope);
  void test_stiffness(const Flow& flow, const Eigen::VectorXd& dy);
  double error_of(const Eigen::VectorXd& scale, double h, int& worst) const;

  const EmbeddedTableau& tableau_;
  double tolerance_;
  StepControl control_;
  // Stiffness test: distance of the previous step's last stage from its end, its step, its slope.
  bool last_known_ = false;
  double last_gap_ = 0, last_step_ = 0;
  Eigen::VectorXd last_slope_;
  int stiff_steps_ = 0, other_steps_ = 0;
  bool stiff_ = false;
  double dense_step_ = 0;               ///< s, length of the step that dense output covers
  bool end_known_ = false;              ///< k_[stages] is the slope at the end of the last attempted step
  std::vector<Eigen::VectorXd> k_;      ///< all stages
  std::vector<Eigen::VectorXd> dense_;  ///< terms of the dense output
  Eigen::VectorXd stage_;
};

/// Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980): 5(4), with
/// Shampine's dense output of order 4. The last stage is the next step's first.
const EmbeddedTableau& dormand_prince_5();

/// Dormand and Prince's eighth-order method with estimates of orders 5 and 3 and dense output of order 7, by
/// Hairer and Wanner.
const EmbeddedTableau& dormand_prince_853();

}  // namespace borelli
