// The impulses of contacts that act together: Signorini's conditions along the normals, Coulomb's friction
// across. With u = u_free + G p, for each contact
//
//   0 <= p_n,  u_n >= target,  p_n (u_n - target) = 0,   |p_t| <= mu p_n,  p_t against u_t where it slips,
//
// written as p = P(p), a projection of p - r u on the half line and on Coulomb's disc. It is solved by
// Newton's method on that equation, which is not smooth where contacts change between open, sticking and
// sliding (Alart and Curnier, A mixed formulation for frictional contact problems prone to Newton like
// solution methods, CMAME 92, 1991). From the impulses of the step before that takes three to six solves.
// Where contacts depend on each other (a box on its corners, bodies that jam each other) G is singular: each
// solve keeps the impulses near what they were, and what a few solves do not settle is come to by proximal
// points (Rockafellar, Monotone operators and the proximal point algorithm, SIAM J. Control Optim. 14, 1976;
// Acary, Bremond, Huber, On solving contact problems with Coulomb friction, 2018), each found by that method;
// where these come no nearer, projected Gauss-Seidel sweeps (Jean, The non-smooth contact dynamics method,
// CMAME 177, 1999) bring them elsewhere.
//
// Nothing here allocates once scratch has grown.
#pragma once

#include <vector>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// n contacts, three rows each: the normal and two across, which are zero where it has none.
struct ContactProblem {
  int count = 0;
  RowsOf<double> G;        ///< velocity along a row by unit impulse along another; symmetric; at least 3n
  Eigen::VectorXd free;    ///< of the rows, m/s: without impulses
  Eigen::VectorXd target;  ///< of the contacts, m/s: the least normal velocity
  std::vector<double> friction;  ///< of the contacts
};

/// Eight of sixteen columns that lie side by side.
struct ColumnPick {
  int first;               ///< -1: they lie farther apart
  long long each[8] = {};  ///< from the first
};

class ContactSolver {
 public:
  /// `impulse` (3n, N s): a guess, and the solution. What is left, in parts of `scale` (m/s): by how much
  /// the projection still changes any velocity. It aims at `settled`; where it comes no nearer, `enough` may
  /// be left.
  double solve(const ContactProblem& problem, double scale, Eigen::VectorXd& impulse, double enough = nearly);
  int worst() const { return worst_; }  ///< the contact with most left
  long solves() const { return solves_; }

  /// Parts of the velocities.
  static constexpr double settled = 1e-8, nearly = 3e-5;

 private:
  void find_responses(const ContactProblem& problem);
  double residual(const ContactProblem& problem, const Eigen::VectorXd& p, const Eigen::VectorXd& u);
  void add_impulses(const ContactProblem& problem, const Eigen::VectorXd& p);
  void update_velocity(const ContactProblem& problem, const Eigen::VectorXd& p);
  void sweep(const ContactProblem& problem, int times, Eigen::VectorXd& p);
  double newton(const ContactProblem& problem, double scale, double enough, double damping,
                Eigen::VectorXd& p);
  void proximal_points(const ContactProblem& problem, double scale, Eigen::VectorXd& p);
  bool find_direction(const ContactProblem& problem, const Eigen::VectorXd& p, double damping);
  template <int width>
  bool solve_modes(const ContactProblem& problem, int symmetric, int stride);

  Eigen::VectorXd u_, change_, best_, best_of_all_, point_, best_point_;
  ContactProblem soft_;
  /// Of a contact's rows to their own impulses, 1/kg; the larger of those across; and the projection's steps,
  /// kg.
  struct Response {
    double own[3], across, normal_step, across_step;
  };
  std::vector<Response> responses_;
  /// Of one solve: what the unknown gives way by, the right side, and of what slides which it is.
  struct Equation {
    double gives, right;
    int slide = -1;
  };
  /// A contact that slides: what p_n brings with it across, and the direction of the other unknown.
  struct Slide {
    int row, unknown;
    double with_x, with_y, x, y;
  };
  std::vector<ColumnPick> picks_;
  RowsOf<double> turned_;  ///< of each slide the row across
  std::vector<int> rows_;  ///< of the unknowns
  std::vector<Equation> equations_;
  std::vector<Slide> slides_;
  struct alignas(64) Line {  // of the cache
    double each[8];
  };
  std::vector<Line> numbers_;  ///< the matrix, a row's right side behind it, the solution, and its parts
  double step_ = 1;
  double near_ = 0;  ///< m/s: what is enough
  int worst_ = 0;
  long solves_ = 0;
};

}  // namespace borelli
