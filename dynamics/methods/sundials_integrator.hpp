// Methods of SUNDIALS for stiff scenes, with dense linear algebra and Jacobians by finite differences:
// CVODE's backward differentiation formulas of order 1 to 5 (Hindmarsh et al., ACM TOMS 31, 2005) and a
// diagonally implicit Runge-Kutta method of ARKODE (Reynolds et al., ACM TOMS 49, 2023). Both choose their
// own steps; CVODE also chooses its order.
#pragma once

#include <memory>

#include "dynamics/methods/integrator.hpp"

namespace borelli {

/// Memory of the Jacobian and its saved copy, bytes.
inline double dense_matrix_bytes(Eigen::Index size) {
  return 2 * sizeof(double) * double(size) * double(size);
}

/// Multistep method with a history: the local coordinates must stay the same over several steps, and no
/// projection may change the state between them.
class CvodeBdf : public Integrator {
 public:
  explicit CvodeBdf(double tolerance);
  ~CvodeBdf() override;
  int order() const override { return 5; }  ///< at most
  bool adaptive() const override { return true; }
  bool keeps_history() const override { return true; }
  double bytes(Eigen::Index size) const override { return dense_matrix_bytes(size); }
  const char* objection(const System& system, ConstraintTreatment treatment) const override;
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  /// CVODE's own interpolation, of the order of the formula in use.
  int dense_order() const override { return 5; }
  bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                     const Eigen::VectorXd& out) override;
  void interpolate(double theta, Eigen::VectorXd& y) const override;
  bool keep(Keeper&) override { return false; }  // its history is CVODE's own
  void reset() override;

 private:
  struct Memory;
  std::unique_ptr<Memory> memory_;
  double tolerance_;
  double from_ = 0, made_ = 0;  ///< s: start and length of the last step
};

/// ESDIRK4(3)7L[2]SA: order 4, L-stable, stiffly accurate, stage order 2 (Kennedy and Carpenter, NASA
/// TM-2016-219173, and Appl. Numer. Math. 146, 2019). A one-step method, so projection may change the state
/// between steps; each step makes a new Jacobian.
class ArkodeDirk : public Integrator {
 public:
  explicit ArkodeDirk(double tolerance);
  ~ArkodeDirk() override;
  int order() const override { return 4; }
  bool adaptive() const override { return true; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  bool keep(Keeper&) override { return false; }  // its step control is ARKODE's own
  double bytes(Eigen::Index size) const override { return dense_matrix_bytes(size); }
  /// None: Hermite's cubic uses the slopes at the ends, whose errors in stiff components are the state's
  /// errors times the stiff rates.
  int dense_order() const override { return 0; }
  bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                 Eigen::VectorXd& out) override;

 private:
  struct Memory;
  int evolve(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy, int how,
             Eigen::VectorXd& out, double& reached);
  std::unique_ptr<Memory> memory_;
  double tolerance_;
};

}  // namespace borelli
