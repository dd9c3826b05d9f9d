// What efforts and constraints see of the moving solids, and where they leave their sums. The engine makes
// one scan per evaluation and points it at each effort or constraint in turn; sites are numbered in the order
// of the kind's fields.
#pragma once

#include <vector>

#include "dynamics/kinematics.hpp"

namespace borelli {

/// A point fixed in a solid: where it is and its velocity; world axes, m, m/s.
struct MovingPoint {
  Eigen::Vector3d p, v;
};

/// Reads the sites of one effort or constraint.
class SiteReader {
 public:
  SiteReader(const System& system, const Parameters& parameters, const Kinematics& kinematics)
      : system_(system), parameters_(parameters), kinematics_(kinematics) {}

  void turn_to(const Action& action) { action_ = &action; }

  double time() const { return kinematics_.t; }
  /// Whether an optional site is given.
  bool given(int site) const { return at_site(site).body >= 0; }
  /// X_WS of the solid at a site.
  Pose frame(int site) const;
  /// The point with coordinates p_S in the solid at a site.
  MovingPoint point(int site, const Eigen::Vector3d& p_S) const;
  /// The velocity of the point of the solid at a site that is at p_W now.
  Eigen::Vector3d velocity(int site, const Eigen::Vector3d& p_W) const;
  Eigen::Vector3d angular_velocity(int site) const { return kinematics_.bodies[at_site(site).body].w; }
  double position(int coordinate) const;
  double rate(int coordinate) const;

 protected:
  const Site& at_site(int site) const { return system_.sites[action_->first_site + site]; }
  const CoordinateSite& at_coordinate(int i) const {
    return system_.coordinate_sites[action_->first_coordinate + i];
  }

  const System& system_;
  const Parameters& parameters_;
  const Kinematics& kinematics_;
  const Action* action_ = nullptr;
};

/// The efforts of one instant, added up: per body a force through its gravity centre and a moment about it.
struct EffortSums {
  explicit EffortSums(const System& system);
  std::vector<Eigen::Vector3d> force, moment;    ///< world axes, N, N m
  Eigen::VectorXd coordinate;                    ///< extended generalized efforts given directly
  double potential = 0;                          ///< J, of springs
  double power = 0;                              ///< W, of what has no potential
  Eigen::VectorXd group_potential, group_power;  ///< the same of each independent group
};

class EffortScan : public SiteReader {
 public:
  EffortScan(const System& system, const Parameters& parameters, const Kinematics& kinematics,
             EffortSums& sums)
      : SiteReader(system, parameters, kinematics), sums_(sums) {}

  /// A force at the point of the solid at a site that is at p_W now; world axes, N.
  void force(int site, const Eigen::Vector3d& p_W, const Eigen::Vector3d& f);
  void torque(int site, const Eigen::Vector3d& m);
  void coordinate(int i, double effort);
  void potential(double energy) {
    sums_.potential += energy;
    sums_.group_potential[action_->group] += energy;
  }
  void power(double power) {
    sums_.power += power;
    sums_.group_power[action_->group] += power;
  }

 private:
  EffortSums& sums_;
};

/// The constraints of one instant: h = 0, dh/dt = L u + partial_rate, d2h/dt2 = L a + E. The columns of L are
/// the extended coordinates.
struct ConstraintRows {
  explicit ConstraintRows(const System& system);
  Rows L;                                    ///< rows x size
  Eigen::VectorXd E, h, rate, partial_rate;  ///< rows
  int degenerate = -1;                       ///< a row that has no direction at this state; -1: none

  struct FunctionScratch {
    Eigen::VectorXd x, rate;
    FunctionDerivatives derivatives;
  };
  std::vector<FunctionScratch> functions;  ///< per constraint, sized for those that are functions
};

class ConstraintScan : public SiteReader {
 public:
  ConstraintScan(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                 ConstraintRows& rows)
      : SiteReader(system, parameters, kinematics), rows_(rows) {}

  /// dh/dt of row r contains f . (velocity of the solid's point at p_W).
  void along(int r, int site, const Eigen::Vector3d& p_W, const Eigen::Vector3d& f);
  /// dh/dt of row r contains m . (angular velocity of the solid).
  void about(int r, int site, const Eigen::Vector3d& m);
  /// dh/dt of row r contains c times the coordinate's rate.
  void coordinate(int r, int i, double c);
  /// The value of row r, its partial derivative by time, and what its second derivative holds beside the
  /// accelerations of the points, solids and coordinates named above.
  void residual(int r, double h, double partial_rate, double bias);
  /// Row r has no direction at this state.
  void degenerate(int r) { rows_.degenerate = action_->first_row + r; }
  ConstraintRows::FunctionScratch& scratch() { return rows_.functions[action_ - system_.constraints.data()]; }

 private:
  ConstraintRows& rows_;
};

/// The linear scans of the paper over efforts and over constraints.
void scan_efforts(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                  EffortSums& sums);
void scan_constraints(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                      ConstraintRows& rows);

}  // namespace borelli
