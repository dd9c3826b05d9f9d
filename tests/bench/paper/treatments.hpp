// The two ways beside which the paper sets its own (Gillard, Nourrit, Lucas, Remion: A generic algorithm for
// the generation of physical movements of solid systems): Lagrange's equations by differences of the kinetic
// energy, and by equations that a symbolic kernel has derived. Both are solved and stepped like each other,
// by the integrators that the program has.
//
// For scenes of hinges and slides that are neither driven nor act on each other but by their weight and by
// points held in planes.
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

/// One way to have the terms at positions q and velocities v.
class Treatment {
 public:
  virtual ~Treatment() = default;
  virtual void terms(const Eigen::VectorXd& q, const Eigen::VectorXd& v, TreatedTerms& out) = 0;
};

/// By differences: K - V of the whole system is evaluated some n^2/2 + 9n/2 times. As K is of second degree
/// in the velocities, differences by them are exact; those by positions are central, with the step that keeps
/// both their truncation and rounding smallest. Fails where the scene holds more than said above.
Result<std::unique_ptr<Treatment>> direct_treatment(const System& system);

/// The function that symbolic.py wrote for a scene.
using SymbolicTerms = void (*)(const double* q, const double* u, double* A, double* f, double* L, double* E,
                               double* h);
std::unique_ptr<Treatment> symbolic_treatment(SymbolicTerms terms);

/// The accelerations; constraints by Baumgarte's restoring ones with the system's gains, as the paper has
/// them.
Eigen::VectorXd accelerations(const System& system, Treatment& treatment, const Eigen::VectorXd& q,
                              const Eigen::VectorXd& v);

/// The treatment under an integrator, for a chart of the system. `make` gives one that is ready.
OtherMethod treated_method(const System& system, const std::string& name, const std::string& integrator,
                           std::function<std::unique_ptr<Treatment>()> make);

}  // namespace borelli
