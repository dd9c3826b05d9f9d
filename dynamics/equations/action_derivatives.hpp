// Derivatives of what efforts and constraints add to inverse dynamics, exact to rounding. An action depends
// only on the motion of its own bodies and on its own coordinates. Its formula on dual numbers gives the
// derivatives of its wrenches by these few numbers. The columns of inverse_derivatives.hpp lead from those to
// the coordinates.
#pragma once

#include <optional>
#include <utility>

#include "dynamics/equations/branch_sparse.hpp"
#include "dynamics/equations/inverse_derivatives.hpp"
#include "dynamics/numbers/dual.hpp"

namespace borelli {

/// Scratch; one per thread. Nothing allocates after the constructor, except user functions.
class ActionDerivatives {
 public:
  explicit ActionDerivatives(const System& system);

  /// Subtracts from by_state the derivatives of the efforts' generalised forces, except the part that
  /// find_inverse_derivatives has counted. `kinematics`: the same as it was given.
  void subtract_efforts(const Parameters& parameters, const Kinematics& kinematics,
                        InverseDerivatives& inverse);

  /// The same for L^T lambda at fixed multipliers lambda (rows), if the efforts given to
  /// find_inverse_derivatives held its wrenches (ConstraintRowsOf::loads). Fills the derivatives of c = L a +
  /// E at the given accelerations, rows x columns of by_state. Contacts count as open.
  void subtract_constraints(const Parameters& parameters, const Kinematics& kinematics,
                            const Eigen::VectorXd& multipliers, InverseDerivatives& inverse,
                            Rows& c_by_state);

  /// Adds the entries that the actions may have.
  void add_pattern(RowPattern& pattern) const;

 private:
  /// What an action depends on and acts on. `input` and `output` are first indices among its numbers.
  struct Layout {
    struct MovedBody {
      int body = 0, input = 0, output = 0;
      std::vector<std::pair<int, int>> moves;  ///< its free coordinates, and their places in `moving`
    };
    struct OwnCoordinate {
      int q = 0, u = 0, nq = 1, nv = 1;
      int input = -1, output = 0;  ///< input -1: driven
      int place = 0;               ///< of its first velocity in `moving`
    };
    std::vector<int> read;  ///< bodies whose motion it reads, without the world
    std::vector<MovedBody> bodies;
    std::vector<OwnCoordinate> coordinates;
    std::vector<int> moving;  ///< free coordinates that it depends on
    int inputs = 0, outputs = 0;
    bool constraint = false;  ///< its last outputs are its rows of c
  };
  Layout lay_out(const Action& action, bool constraint) const;
  int place_of(int u, Layout& layout) const;
  template <class Apply>
  void differentiate(const Action& action, const Layout& layout, const Kinematics& kinematics, Apply&& apply);
  void load(const Action& action, const Layout& layout, const Kinematics& kinematics);
  void seed(const Layout& layout, int input, int direction);
  void keep(const Action& action, const Layout& layout, int first, int count);
  void chain(const Layout& layout, const Parameters& parameters, const Kinematics& kinematics,
             const InverseDerivatives& inverse);
  void subtract(const Layout& layout, const Kinematics& kinematics, InverseDerivatives& inverse) const;

  const System& system_;
  std::vector<Layout> efforts_, constraints_;
  KinematicsOf<DualNumber> kinematics_;
  EffortSumsOf<DualNumber> sums_;
  std::optional<ConstraintRowsOf<DualNumber>> rows_;
  Eigen::VectorXd values_;               ///< outputs
  Eigen::MatrixXd local_;                ///< outputs x inputs
  Eigen::MatrixXd change_q_, change_v_;  ///< outputs x moving coordinates
};

}  // namespace borelli
