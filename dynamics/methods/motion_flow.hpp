// The motion of a system as a differential equation: what integrators are given.
#pragma once

#include <memory>

#include "dynamics/equations/equations.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/methods/work.hpp"

namespace borelli {

/// dy/dt = f(t, y), y = (local coordinates x, velocities v, work of the four powers, work on each independent
/// group, and where several groups have constraint rows, the work of rows that are off on each). The local
/// coordinates are centred on the state given to start().
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
  /// Where a batch can have the scene (batch.hpp), no row holds, nothing depends on time, the solids do not
  /// mostly swing by themselves (of those, one state takes hardly any time) and no lane had to be solved by
  /// itself.
  bool has_lanes() override;
  bool derivatives(const Eigen::VectorX<Quad>& y, int states, Eigen::VectorX<Quad>& dy) override;
  bool derivatives(const Eigen::VectorX<Lanes>& y, int states, Eigen::VectorX<Lanes>& dy) override;

  /// Centres the local coordinates on a state, fills y and dy there, decides the rank of the constraints for
  /// the step to come. Leaves the equations at that state in the workspace. Where they are there already (the
  /// last slope that the integrator asked for was at this state, and there are no rows), they are not solved
  /// again. False: they cannot be solved; see failure().
  bool start(const State& state, const Work& work, Eigen::VectorXd& y, Eigen::VectorXd& dy);

  /// Instead of start(), for a method that keeps its history: readies the step from `state` at y in the local
  /// coordinates as it is. False: as in start().
  bool go_on(const State& state, const Eigen::VectorXd& y, Eigen::VectorXd& dy);
  /// Whether a ball has turned by more than a radian from the centre of the local coordinates at y.
  bool off_centre(const Eigen::VectorXd& y) const;

  /// The position, velocity and work that y stands for.
  void take(const Eigen::VectorXd& y, State& state, Work& work) const;

  const MotionFlow* motion() const override { return this; }
  const System& system() const { return system_; }
  /// The equations as last solved, with all that they give there.
  const Workspace& workspace() const {
    complete(system_, system_.parameters, w_);
    return w_;
  }
  /// Whether constraint rows are kept by projection.
  bool projects() const { return system_.rows > 0 && projects_; }

  /// How far a state is from that which y stands for, on error_scale(): the component most so.
  double distance(const Eigen::VectorXd& y, const State& state);

  /// How the constraint rows enter the equations; with the rank decided anew.
  const RowHandling& handling() const { return handling_; }
  /// Why the last slope could not be had, at time t.
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
  std::vector<int> groups_with_rows_, apart_groups_;  ///< the latter: the same if several, else none
  Fault fault_;
  int turned_ = -1;  ///< the velocity whose ball turned too far for the local coordinates; -1: none
  Eigen::VectorXd q0_, scale_;
  /// The groups whose work an adaptive method's steps follow: those that drives or constraints move.
  std::vector<char> counted_groups_;
  /// Of each group, J: its kinetic energy where every coordinate moves by its scale per second; the largest
  /// so far.
  Eigen::VectorXd unit_energy_, largest_energy_;
  // where derivative() last solved the equations
  bool solved_ = false;
  double last_time_ = 0;
  Eigen::VectorXd q_, last_v_;
  long evaluations_ = -1;  ///< the workspace's count then
  bool lanes_fit_;         ///< has_lanes() while no row holds
  template <class T>
  struct Together;
  template <class T>
  bool solve_together(std::unique_ptr<Together<T>>& together, const Eigen::VectorX<T>& y, int states,
                      Eigen::VectorX<T>& dy);
  // what several states at once ask for; none before the first
  std::unique_ptr<Together<Quad>> four_;
  std::unique_ptr<Together<Lanes>> eight_;
};

}  // namespace borelli
