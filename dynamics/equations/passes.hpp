// Interface of efforts and constraints to the moving solids and to their sums. One pass serves an evaluation
// and is turned to each effort or constraint in turn. Sites are numbered in the order of the kind's fields.
#pragma once

#include <array>
#include <vector>

#include "dynamics/equations/kinematics.hpp"

namespace borelli {

/// Position and velocity of a point fixed in a solid; world axes, m, m/s.
template <class T>
struct MovingPoint {
  Eigen::Vector3<T> p, v;
};

/// Reads the sites of one effort or constraint.
template <class T>
class SiteReader {
 public:
  SiteReader(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics)
      : system_(system), parameters_(parameters), kinematics_(kinematics) {}

  void turn_to(const Action& action) { action_ = &action; }

  double time() const { return kinematics_.t; }
  /// Whether an optional site was given.
  bool given(int site) const { return at_site(site).body >= 0; }
  /// X_WS of the solid at a site.
  PoseOf<T> frame(int site) const {
    const Site& s = at_site(site);
    const PoseOf<T>& X_WB = kinematics_.bodies[s.body].X;
    return s.solid < 0 ? X_WB : X_WB * parameters_.solid_places[s.solid];
  }
  /// The point with coordinates p_S in the solid at a site.
  MovingPoint<T> point(int site, const Eigen::Vector3d& p_S) const {
    const Site& s = at_site(site);
    const Eigen::Vector3d p_B = s.solid < 0 ? p_S : parameters_.solid_places[s.solid] * p_S;
    const Eigen::Vector3<T> p_W = kinematics_.bodies[s.body].X * p_B;
    return {p_W, velocity(site, p_W)};
  }
  /// Velocity of the point of a site's solid that is now at p_W.
  Eigen::Vector3<T> velocity(int site, const Eigen::Vector3<T>& p_W) const {
    const BodyMotionOf<T>& body = kinematics_.bodies[at_site(site).body];
    const Eigen::Vector3<T> r = p_W - body.g, &w = body.w;
    // (number by number: a vector product stored in pairs would stall the scalar loads)
    return {body.v[0] + (w[1] * r[2] - w[2] * r[1]), body.v[1] + (w[2] * r[0] - w[0] * r[2]),
            body.v[2] + (w[0] * r[1] - w[1] * r[0])};
  }
  Eigen::Vector3<T> angular_velocity(int site) const { return kinematics_.bodies[at_site(site).body].w; }
  /// Position and rate of a scalar coordinate. (A locked one keeps its value.)
  T position(int coordinate) const;
  T rate(int coordinate) const;
  /// A ball's quaternion, and its angular velocity in its own axes.
  QuaternionOf<T> turn(int coordinate) const;
  Eigen::Vector3<T> turn_rate(int coordinate) const;

 protected:
  const Site& at_site(int site) const { return system_.sites[action_->first_site + site]; }
  const CoordinateSite& at_coordinate(int i) const {
    return system_.coordinate_sites[action_->first_coordinate + i];
  }

  const System& system_;
  const Parameters& parameters_;
  const KinematicsOf<T>& kinematics_;
  const Action* action_ = nullptr;
};

/// Sums of the efforts at one instant: per body, a force through its gravity centre and a moment about it.
template <class T>
struct EffortSumsOf {
  explicit EffortSumsOf(const System& system);
  std::vector<Eigen::Vector3<T>> force, moment;    ///< world axes, N, N m
  Eigen::VectorX<T> coordinate;                    ///< generalised forces applied directly, extended
  T potential = 0;                                 ///< J, of springs
  T power = 0;                                     ///< W, of efforts without a potential
  Eigen::VectorX<T> group_potential, group_power;  ///< the same per independent group
};
using EffortSums = EffortSumsOf<double>;

template <class T>
class EffortPass : public SiteReader<T> {
 public:
  EffortPass(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
             EffortSumsOf<T>& sums)
      : SiteReader<T>(system, parameters, kinematics), sums_(sums) {}

  /// Applies a force f to the point of a site's solid that is now at p_W; world axes, N.
  void force(int site, const Eigen::Vector3<T>& p_W, const Eigen::Vector3<T>& f);
  void torque(int site, const Eigen::Vector3<T>& m);
  void coordinate(int i, const T& effort);
  /// A torque on a ball coordinate, in its own axes, N m.
  void turning(int i, const Eigen::Vector3<T>& torque);
  void potential(const T& energy) {
    sums_.potential += energy;
    sums_.group_potential[this->action_->group] += energy;
  }
  void power(const T& power) {
    sums_.power += power;
    sums_.group_power[this->action_->group] += power;
  }

 private:
  EffortSumsOf<T>& sums_;
};

/// The constraints of one instant: h = 0, dh/dt = L u + partial_rate, d2h/dt2 = L a + E. The columns of L are
/// the extended coordinates.
template <class T>
struct ConstraintRowsOf {
  explicit ConstraintRowsOf(const System& system);
  RowsOf<T> L;                                 ///< rows x size
  Eigen::VectorX<T> E, h, rate, partial_rate;  ///< rows
  int degenerate = -1;                         ///< row without a direction at this state; -1: none
  Eigen::VectorXd
      speed;  ///< per row, of a gap between long shapes: bound on the approach speed of any two of their
              ///< points, m/s

  /// Mode of each contact. Rows that its mode does not use are empty: no direction, no value.
  std::vector<ContactMode> modes;
  /// Per sliding contact: slip direction as a row (contacts x size), and its components along the two
  /// tangential rows.
  RowsOf<T> slip;
  std::vector<std::array<T, 2>> slip_along;
  /// Clears everything, for a state without active rows.
  void empty();
  bool every_row = false;  ///< keep the rows of all contacts in every mode
  /// What a scan fills. `rates` and `values` leave L and E unchanged, need only poses and velocities of
  /// bodies, and skip tangential rows of contacts with planes.
  enum class Detail { rows, rates, values } detail = Detail::rows;
  /// Per constraint, for scans of rates and values: skip it and leave its values unchanged, its rates zero
  /// (see far_pairs.hpp). Empty: skip none.
  std::vector<char> far;

  /// If set, the scan also adds the forces of these multipliers on the bodies to `bodies`.
  struct Loads {
    const Eigen::VectorXd* multipliers = nullptr;
    EffortSumsOf<T>* bodies = nullptr;
  };
  Loads loads;

  struct FunctionScratch {
    Eigen::VectorX<T> x, rate, gradient;
    Eigen::VectorXd at, moved;
    FunctionDerivatives h, ahead, behind;
  };
  std::vector<FunctionScratch> functions;  ///< per constraint; sized only for function constraints
};
using ConstraintRows = ConstraintRowsOf<double>;

template <class T>
class ConstraintPass : public SiteReader<T> {
 public:
  ConstraintPass(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                 ConstraintRowsOf<T>& rows)
      : SiteReader<T>(system, parameters, kinematics), rows_(rows) {}

  /// A range of columns of L.
  struct Columns {
    int first, count;
  };
  /// Zeroes the constraint's rows of L where they can have entries, and returns that range.
  Columns clear();
  /// Adds f . (velocity of the solid's point at p_W) to dh/dt of row r.
  void along(int r, int site, const Eigen::Vector3<T>& p_W, const Eigen::Vector3<T>& f) {
    along_each<1>(r, site, p_W, f);
  }
  /// The same for row r and the following ones, one per column of f.
  template <int N>
  void along_each(int r, int site, const Eigen::Vector3<T>& p_W, const Eigen::Matrix<T, 3, N>& f);
  /// Adds m . (angular velocity of the solid) to dh/dt of row r.
  void about(int r, int site, const Eigen::Vector3<T>& m);
  /// Adds c times the coordinate's rate to dh/dt of row r.
  void coordinate(int r, int i, const T& c);
  /// Sets the value h of row r and its partial derivative by time. `bias`: the part of d2h/dt2 beyond the
  /// accelerations of the points, solids and coordinates named above.
  void residual(int r, const T& h, const T& partial_rate, const T& bias);
  /// Row r is a gap whose nearest points may change soon; its points approach no faster than `fastest`, m/s.
  void speed(int r, double fastest) { rows_.speed[this->action_->first_row + r] = fastest; }
  /// Marks row r as having no direction at this state.
  void degenerate(int r) { rows_.degenerate = this->action_->first_row + r; }
  using Detail = typename ConstraintRowsOf<T>::Detail;
  Detail detail() const { return rows_.detail; }
  auto& scratch() { return rows_.functions[this->action_ - this->system_.constraints.data()]; }

 private:
  ConstraintRowsOf<T>& rows_;
};

/// The paper's linear scans over efforts and over constraints.
template <class T>
void scan_efforts(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                  EffortSumsOf<T>& sums);
template <class T>
void scan_constraints(const System& system, const Parameters& parameters, const KinematicsOf<T>& kinematics,
                      ConstraintRowsOf<T>& rows);

/// Fills the rows of one constraint, in every contact mode.
void scan_constraint(const System& system, const Parameters& parameters, const Kinematics& kinematics,
                     int constraint, ConstraintRows& rows);

}  // namespace borelli
