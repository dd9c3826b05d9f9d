// The step just made, as a function of time: the state anywhere in it, on the constraints, for output between
// steps and for events.
#pragma once

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/methods/motion_flow.hpp"

namespace borelli {

/// A state of a step, put on the constraints if that is how they are kept.
struct Landing {
  State state;
  Work work;               ///< done until then; what the projection at this state does is not in it
  bool projected = false;  ///< was put on the constraints, and that is not booked yet
  Projection projection;   ///< what that did
  explicit Landing(const System& system) : work(system.groups) {}
  /// Books what the projection did, once, from the equations solved at the state.
  void book_projection(const Workspace& workspace);
};

class StepPath {
 public:
  /// `motion` and `integrator` are those that make the steps; `probe` is scratch that nothing else relies on,
  /// null for a scene without rows.
  StepPath(const System& system, const SimulationSettings& settings, MotionFlow& motion,
           Integrator& integrator, Workspace* probe);

  /// The step of h from (t, y), where the slope is dy and the work `work`, that came to `out`: until the next
  /// call the arguments must stay as they are, and the motion's local coordinates where they were.
  void begin(double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
             const Eigen::VectorXd& out, const Work& work);

  /// The state at t + theta h, theta from 0 to 1: of dense output where that is as good as the steps, else of
  /// a step so much shorter. Fails where the equations cannot be solved or the constraints not be met.
  Result<void> land(double theta, Landing& landing);
  /// The same as it comes, not put on the constraints: off them by about what the step is off.
  Result<void> glance(double theta, Landing& landing);
  /// Whether the method has dense output of its own that is coarser than its steps, which are long.
  bool has_outline() const { return integrator_.dense_order() > 3 && !integrator_.dense_suffices(); }
  /// The state at t + theta h of that, as it comes.
  Result<void> outline(double theta, Landing& landing);
  /// The state at the time given, where the step ends.
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
