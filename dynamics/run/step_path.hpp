// The last step as a function of time: states within it, on the constraints, for output between steps and for
// events.
#pragma once

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/methods/motion_flow.hpp"

namespace borelli {

/// A state within a step, projected on the constraints if they are kept by projection.
struct Landing {
  State state;
  Work work;               ///< until this state, without the projection at this state
  bool projected = false;  ///< the state was projected and the projection is not booked yet
  Projection projection;   ///< result of the projection
  explicit Landing(const System& system) : work(system.groups) {}
  /// Books the work of the projection, once. `workspace` holds the equations at the state.
  void book_projection(const Workspace& workspace);
};

class StepPath {
 public:
  /// `motion` and `integrator` make the steps. `probe` is exclusive scratch; null for a scene without rows.
  StepPath(const System& system, const SimulationSettings& settings, MotionFlow& motion,
           Integrator& integrator, Workspace* probe);

  /// Sets the step of h from (t, y), with slope dy and work `work`, to `out`. The arguments and the centre of
  /// the motion's local coordinates must stay unchanged until the next call.
  void begin(double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
             const Eigen::VectorXd& out, const Work& work);

  /// The state at t + theta h, 0 <= theta <= 1: from dense output if it is as accurate as the steps,
  /// otherwise from a shorter step. Fails if the equations cannot be solved or the constraints cannot be met.
  Result<void> land(double theta, Landing& landing);
  /// As land() without projection; the constraints are violated by about the step's error.
  Result<void> glance(double theta, Landing& landing);
  /// Whether the method has its own dense output that is less accurate than its (long) steps.
  bool has_outline() const { return integrator_.dense_order() > 3 && !integrator_.dense_suffices(); }
  /// The state at t + theta h from that dense output, without projection.
  Result<void> outline(double theta, Landing& landing);
  /// The state at the step's end, at time `end`, projected as in land().
  Result<void> land_at_end(double end, Landing& landing);

 private:
  bool ready();
  Result<void> find_between(double theta);
  void take(const Eigen::VectorXd& y, double t, Landing& landing);
  Result<void> settle(const Eigen::VectorXd& y, double t, Landing& landing);

  const System& system_;
  bool projecting_;
  MotionFlow& motion_;
  Integrator& integrator_;
  Workspace* probe_;
  double t_ = 0, h_ = 0;
  const Eigen::VectorXd *y_ = nullptr, *dy_ = nullptr, *out_ = nullptr;
  const Work* work_ = nullptr;
  bool dense_ready_ = false;
  Eigen::VectorXd between_;
};

}  // namespace borelli
