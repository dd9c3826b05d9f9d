// Solves for the impulses of simultaneous contacts: Signorini's conditions along the normals, Coulomb's
// friction in the tangential plane. With u = u_free + G p, for each contact
//
//   0 <= p_n,  u_n >= target,  p_n (u_n - target) = 0,   |p_t| <= mu p_n,  p_t opposes u_t if it slips,
//
// written as p = P(p), the projection of p - r u onto the half line and Coulomb's disc. Newton's method
// solves this equation, which is not smooth where contacts change between open, sticking and sliding (Alart
// and Curnier, A mixed formulation for frictional contact problems prone to Newton like solution methods,
// CMAME 92, 1991). From the impulses of the previous step it needs three to six solves.
//
// If contacts depend on each other (a box on its corners, bodies that jam each other), G is singular. Each
// solve is then damped towards the current impulses. If a few solves do not converge, proximal points follow,
// each solved by Newton's method (Rockafellar, Monotone operators and the proximal point algorithm, SIAM J.
// Control Optim. 14, 1976; Acary, Bremond, Huber, On solving contact problems with Coulomb friction, 2018).
// If these stall, projected Gauss-Seidel sweeps (Jean, The non-smooth contact dynamics method, CMAME 177,
// 1999) give another starting point.
//
// Nothing here allocates once scratch has grown.
#pragma once

#include <vector>

#include "dynamics/numbers/scalar.hpp"

namespace borelli {

/// n contacts, three rows each: the normal and two tangential ones, which are zero for a contact without
/// friction rows.
struct ContactProblem {
  int count = 0;
  RowsOf<double> G;              ///< velocity per unit impulse, row by row, 1/kg; symmetric; at least 3n
  Eigen::VectorXd free;          ///< per row: velocity without impulses, m/s
  Eigen::VectorXd target;        ///< per contact: least normal velocity, m/s
  std::vector<double> friction;  ///< per contact: coefficient mu
};

/// Eight columns chosen from sixteen consecutive ones.
struct ColumnPick {
  int first;               ///< first of the sixteen; -1: the chosen columns lie farther apart
  long long each[8] = {};  ///< offsets from the first
};

class ContactSolver {
 public:
  /// `impulse` (3n, N s): initial guess, then the solution. Returns the residual: the largest velocity change
  /// that the projection still makes, over `scale` (m/s). Iterates down to `settled`; accepts `enough` if
  /// that is out of reach.
  double solve(const ContactProblem& problem, double scale, Eigen::VectorXd& impulse, double enough = nearly);
  int worst() const { return worst_; }  ///< the contact with the largest residual
  long solves() const { return solves_; }

  /// Residuals over `scale`.
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
  /// Of one contact: response of each row to its own impulse, 1/kg; the larger tangential one; step sizes r
  /// of the projection, kg.
  struct Response {
    double own[3], across, normal_step, across_step;
  };
  std::vector<Response> responses_;
  /// One Newton row: regularisation, right-hand side, index into `slides_` (-1: not sliding).
  struct Equation {
    double gives, right;
    int slide = -1;
  };
  /// A sliding contact: its normal row; its tangential unknown; friction (with_x, with_y) per unit p_n;
  /// direction (x, y) of the unknown, perpendicular to that friction.
  struct Slide {
    int row, unknown;
    double with_x, with_y, x, y;
  };
  std::vector<ColumnPick> picks_;
  RowsOf<double> turned_;  ///< per sliding contact, the row of G along (x, y)
  std::vector<int> rows_;  ///< row of each unknown
  std::vector<Equation> equations_;
  std::vector<Slide> slides_;
  struct alignas(64) Line {  // one cache line
    double each[8];
  };
  std::vector<Line> numbers_;  ///< the matrix with its right-hand sides, the solution, scratch of the
                               ///< elimination
  double step_ = 1;
  double near_ = 0;  ///< accepted residual, m/s
  int worst_ = 0;
  long solves_ = 0;
};

}  // namespace borelli
