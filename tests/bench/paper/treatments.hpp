// The two treatments that the paper compares with its own (Gillard, Nourrit, Lucas, Remion: A generic
// algorithm for the generation of physical movements of solid systems): Lagrange's equations by differences
// of the kinetic energy, and equations that a symbolic kernel derived. Both are solved in the same way and
// stepped by the program's integrators.
//
// For scenes of undriven hinges and slides under weight alone, with points held in planes.
#pragma once

#include <memory>

#include "pipeline/charts/work_precision.hpp"

namespace borelli {

struct System;

/// A (n x n) and f of A a = f + L^T lambda; of rows h(q) = 0 their Jacobian L (rows x n), E of L a + E = 0,
/// and h. By rows; SI.
struct TreatedTerms {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> A, L;
  Eigen::VectorXd f, E, h;
};

/// One way to compute the terms at positions q and velocities v.
class Treatment {
 public:
  virtual ~Treatment() = default;
  virtual void terms(const Eigen::VectorXd& q, const Eigen::VectorXd& v, TreatedTerms& out) = 0;
};

/// By differences: K - V of the whole system is evaluated about n^2/2 + 9n/2 times. K is quadratic in the
/// velocities, so differences by velocities are exact. Those by positions are central, with the step that
/// balances truncation and rounding. Fails where the scene holds more than said above.
Result<std::unique_ptr<Treatment>> direct_treatment(const System& system);

/// The function that symbolic.py wrote for a scene.
using SymbolicTerms = void (*)(const double* q, const double* u, double* A, double* f, double* L, double* E,
                               double* h);
std::unique_ptr<Treatment> symbolic_treatment(SymbolicTerms terms);

/// The accelerations, with constraints held by Baumgarte stabilisation at the system's gains, as in the
/// paper.
Eigen::VectorXd accelerations(const System& system, Treatment& treatment, const Eigen::VectorXd& q,
                              const Eigen::VectorXd& v);

/// The treatment with an integrator, as a method for a chart of the system. `make` gives one that is ready.
OtherMethod treated_method(const System& system, const std::string& name, const std::string& integrator,
                           std::function<std::unique_ptr<Treatment>()> make);

}  // namespace borelli
