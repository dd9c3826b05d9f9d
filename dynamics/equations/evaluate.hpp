// The equations at one state, for people and other programs: `borelli evaluate`.
#pragma once

#include "dynamics/equations/jacobian.hpp"

namespace borelli {

/// A a + B = Q + L^T lambda, L a + E = 0, over the free coordinates. B holds the velocity terms alone (driven
/// coordinates' accelerations included), Q weight, springs, dampers and given efforts.
struct Evaluation {
  std::vector<std::string> coordinates;  ///< one name per velocity; a ball's three end in .x, .y, .z
  Rows mass_matrix;                      ///< A, nv x nv
  Eigen::VectorXd bias;                  ///< B
  Eigen::VectorXd generalized_efforts;   ///< Q
  Eigen::VectorXd acceleration;          ///< a
  std::vector<std::string> rows;         ///< names of constraint rows
  Rows constraint_jacobian;              ///< L, rows x nv
  Eigen::VectorXd constraint_bias;       ///< E
  Eigen::VectorXd multipliers;           ///< lambda
  Eigen::VectorXd drive_efforts;         ///< what driven coordinates exert
  double kinetic_energy = 0, potential_energy = 0;  ///< J
  Momenta momenta;                                  ///< of all moving solids
  CentroidalMomentum centroidal;
};

/// At `state`, as it is (constraints are not put right). `efforts`, if not empty, holds nv generalized
/// efforts more.
Result<Evaluation> evaluate(const System& system, const State& state,
                            const Eigen::VectorXd& efforts = Eigen::VectorXd());

/// Whether a state fits a system: sizes, finite numbers, unit quaternions (within 1e-3).
Result<void> check_state(const System& system, const State& state);

}  // namespace borelli
