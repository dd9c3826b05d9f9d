// The motion of a system as a differential equation for integrators.
#pragma once

#include <memory>

#include "dynamics/equations/equations.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/methods/work.hpp"

namespace borelli {

/// dy/dt = f(t, y) with y = (local coordinates x, velocities v, work of the four powers, work on each
/// independent group and, if several groups have constraint rows, the work of violated rows on each of them).
/// The local coordinates are centred on the state given to start().
class MotionFlow : public Flow {
 public:
  MotionFlow(const System& system, const SimulationSettings& settings, Workspace& workspace);
  ~MotionFlow() override;

  Eigen::Index size() const override {
    return 2 * system_.nv + 4 + system_.groups + Eigen::Index(apart_groups_.size());
  }
  const Eigen::VectorXd& error_scale() const override { return scale_; }
  Eigen::Index positions() const override { return system_.nv; }
  void position_rate(const Eigen::VectorXd& y, Eigen::VectorXd& dy) override;
  void position_rates(const Eigen::VectorX<Lanes>& y, Eigen::VectorX<Lanes>& dy) override;
  bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) override;
  /// True if a batch can evaluate the scene (batch.hpp), no row is active, nothing depends on time, no lane
  /// had to be solved separately, and at most half of the solids are single pendulums (one state of those is
  /// cheap enough).
  bool has_lanes() override;
  bool derivatives(const Eigen::VectorX<Quad>& y, int states, Eigen::VectorX<Quad>& dy) override;
  bool derivatives(const Eigen::VectorX<Lanes>& y, int states, Eigen::VectorX<Lanes>& dy) override;

  /// Centres the local coordinates on `state`, fills y and dy there and decides the rank of the constraints
  /// for the coming step. Leaves the equations at `state` in the workspace. It does not solve them again if
  /// the integrator's last slope was at this state and there are no rows. Returns false if they cannot be
  /// solved; see failure().
  bool start(const State& state, const Work& work, Eigen::VectorXd& y, Eigen::VectorXd& dy);

  /// Replaces start() for a method that keeps its history: prepares the step from `state`, at y in the
  /// present local coordinates. Returns false as in start().
  bool go_on(const State& state, const Eigen::VectorXd& y, Eigen::VectorXd& dy);
  /// Whether a ball has turned by more than a radian from the centre of the local coordinates at y.
  bool off_centre(const Eigen::VectorXd& y) const;

  /// Sets position, velocity and work from y.
  void take(const Eigen::VectorXd& y, State& state, Work& work) const;

  const MotionFlow* motion() const override { return this; }
  const System& system() const { return system_; }
  /// The last solution of the equations, completed with everything they give at that state.
  const Workspace& workspace() const {
    complete(system_, system_.parameters, w_);
    return w_;
  }
  /// Whether projection keeps the constraint rows.
  bool projects() const { return system_.rows > 0 && projects_; }

  /// Largest difference of a component between `state` and y, in units of error_scale().
  double distance(const Eigen::VectorXd& y, const State& state);

  /// How the constraint rows enter the equations when the rank is decided anew.
  const RowHandling& handling() const { return handling_; }
  /// Why the last slope could not be evaluated, at time t (s).
  Error failure(double t) const;
  /// The name of component i of y.
  std::string component(int i) const;

  template <class Keeper>
  void keep(Keeper& k) {
    k(q0_, scale_, solved_, last_time_, q_, last_v_, evaluations_, unit_energy_, largest_energy_, lanes_fit_);
  }

 private:
  void set_scale(const State& state);
  void set_work_scale();
  bool find_unit_energies(const State& state);
  bool turned_too_far(const Eigen::VectorXd& y);
  void fill(const Eigen::VectorXd& y, Eigen::VectorXd& dy) const;

  const System& system_;
  Workspace& w_;
  RowHandling handling_, within_step_;
  bool projects_;
  std::vector<int> groups_with_rows_, apart_groups_;  ///< apart_groups_: the same if several, else empty
  Fault fault_;
  int turned_ = -1;  ///< velocity index of a ball that turned too far for the local coordinates; -1: none
  Eigen::VectorXd q0_, scale_;
  /// Groups whose work an adaptive method controls: those that drives or constraints move.
  std::vector<char> counted_groups_;
  /// Per group, J: kinetic energy if every coordinate moves by its scale per second; largest kinetic energy
  /// so far.
  Eigen::VectorXd unit_energy_, largest_energy_;
  // State of the last solution in derivative().
  bool solved_ = false;
  double last_time_ = 0;
  Eigen::VectorXd q_, last_v_;
  long evaluations_ = -1;  ///< evaluation count of the workspace at that solution
  bool lanes_fit_;         ///< has_lanes() while no row is active
  template <class T>
  struct Together;
  template <class T>
  bool solve_together(std::unique_ptr<Together<T>>& together, const Eigen::VectorX<T>& y, int states,
                      Eigen::VectorX<T>& dy);
  // Workspaces for several states at once; allocated on first use.
  std::unique_ptr<Together<Quad>> four_;
  std::unique_ptr<Together<Lanes>> eight_;
};

}  // namespace borelli
