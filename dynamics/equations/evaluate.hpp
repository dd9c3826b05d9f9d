// The equations at one state, for users and other programs: `borelli evaluate`.
#pragma once

#include "dynamics/equations/equations.hpp"
#include "dynamics/equations/jacobian.hpp"

namespace borelli {

/// A a + B = Q + L^T lambda, L a + E = 0, over the free coordinates. B holds the velocity terms and the
/// accelerations of driven coordinates; Q holds weight, springs, dampers and given forces.
struct Evaluation {
  std::vector<std::string> coordinates;  ///< one name per velocity; a ball's three end in .x, .y, .z
  Rows mass_matrix;                      ///< A, nv x nv
  Eigen::VectorXd bias;                  ///< B
  Eigen::VectorXd generalized_efforts;   ///< Q
  Eigen::VectorXd acceleration;          ///< a
  std::vector<std::string> rows;         ///< names of constraint rows
  Rows constraint_jacobian;              ///< L, rows x nv
  Eigen::VectorXd constraint_bias;       ///< E
  Eigen::VectorXd constraint_position;   ///< h, m or rad: the residual of each row
  Eigen::VectorXd constraint_rate;       ///< dh/dt
  Eigen::VectorXd multipliers;           ///< lambda
  Eigen::VectorXd drive_efforts;         ///< driven coordinates' generalised forces
  double kinetic_energy = 0, potential_energy = 0;  ///< J
  Momenta momenta;                                  ///< of all moving solids
  CentroidalMomentum centroidal;
};

/// At the given state (not assembled). `efforts`, if not empty, holds nv additional generalised forces. Fails
/// if a size or state does not fit, or if the equations cannot be solved.
Result<Evaluation> evaluate(const System& system, const State& state,
                            const Eigen::VectorXd& efforts = Eigen::VectorXd());

/// The same in a Workspace of the system, which saves its allocation at every state but the first.
Result<Evaluation> evaluate(const System& system, const State& state, const Eigen::VectorXd& efforts,
                            Workspace& workspace);

/// Describes the constraint row with the largest residual relative to its length: "constraint 'rod' is
/// violated by 0.8" (m or rad). Empty if no residual exceeds 1e-6 of its row's length. Accelerations do not
/// correct such a residual.
std::string violation(const System& system, const Evaluation& evaluated);

/// Whether a state fits a system: sizes, finite numbers, unit quaternions (within 1e-3).
Result<void> check_state(const System& system, const State& state);

}  // namespace borelli
