// Methods for dy/dt = f(t, y), one step at a time. To add a method, write one file like
// explicit_runge_kutta.cpp that makes an Integrator, and add a line to the list in integrator.cpp.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/numbers/keeper.hpp"
#include "dynamics/numbers/lanes.hpp"
#include "dynamics/scene/settings.hpp"
#include "error/error.hpp"

namespace borelli {

class MotionFlow;
struct ContactStep;
struct System;

/// The right-hand side f of the differential equation.
class Flow {
 public:
  virtual ~Flow() = default;
  virtual Eigen::Index size() const = 0;
  /// dy <- f(t, y). Returns false if f cannot be evaluated there.
  virtual bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) = 0;
  /// Per component, the size that adaptive methods measure errors against; infinity: not controlled.
  virtual const Eigen::VectorXd& error_scale() const = 0;
  /// How many of y's first components are positions; the same number of velocities follows. 0: the flow does
  /// not distinguish them.
  virtual Eigen::Index positions() const { return 0; }
  /// The derivative of the positions alone, which is cheap.
  virtual void position_rate(const Eigen::VectorXd& /*y*/, Eigen::VectorXd& /*dy*/) {}
  /// The same for eight states side by side.
  virtual void position_rates(const Eigen::VectorX<Lanes>& /*y*/, Eigen::VectorX<Lanes>& /*dy*/) {}
  /// Whether f does not depend on time and is cheaper at several states side by side than at one after the
  /// other.
  virtual bool has_lanes() { return false; }
  /// With has_lanes(): dy <- f(y) in each lane. Only the results of the first `states` lanes are used; the
  /// other lanes must hold states that can be evaluated. Returns false if f cannot be evaluated at one of
  /// them.
  virtual bool derivatives(const Eigen::VectorX<Quad>& /*y*/, int /*states*/, Eigen::VectorX<Quad>& /*dy*/) {
    return false;
  }
  virtual bool derivatives(const Eigen::VectorX<Lanes>& /*y*/, int /*states*/,
                           Eigen::VectorX<Lanes>& /*dy*/) {
    return false;
  }
  /// The flow as the motion of a system, for methods that need more than slopes; null: it is none.
  virtual const MotionFlow* motion() const { return nullptr; }
};

/// The result of an attempted step.
struct Attempt {
  /// Returns false if f could not be evaluated within the step; `out` is undefined.
  bool evaluated = true;
  bool accepted = true;  ///< false: the error is too large; try again with next_step
  /// The step that the method proposes, s. Fixed methods return h.
  double next_step = 0;
  int worst = -1;  ///< the component with the largest error, if the method estimates it
  /// The step made, s, by a method that chooses it itself (at most h); 0: h.
  double made = 0;
  int rejected = 0;  ///< tries with longer steps within this attempt, for such methods
  /// The cause if the failure is not f's; the run cannot continue. Null otherwise.
  const char* trouble = nullptr;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual int order() const = 0;
  virtual bool adaptive() const = 0;
  /// One step of h from (t, y); dy = f(t, y) is given. `out` <- y at t + h. The method may remember data of
  /// earlier steps.
  virtual Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                          Eigen::VectorXd& out) = 0;

  /// A first step to try, estimated from f and its rate of change. 0: the method has no estimate, or nothing
  /// moves. Evaluates f once.
  virtual double first_step(Flow& /*flow*/, double /*t*/, const Eigen::VectorXd& /*y*/,
                            const Eigen::VectorXd& /*dy*/) {
    return 0;
  }

  /// The order of dense output: its error over a step goes as h^(dense_order() + 1). The default is Hermite's
  /// cubic through values and slopes at both ends, order 3.
  virtual int dense_order() const { return 3; }
  /// Whether dense output is as accurate as the steps, whose errors accumulate to h^order().
  bool dense_suffices() const { return dense_order() + 1 >= order(); }
  /// Prepares interpolate() for the step last attempted, from (t, y) to `out`. Returns false if f could not
  /// be evaluated.
  virtual bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& dy, const Eigen::VectorXd& out);
  /// y at t + theta h of that step, theta from 0 to 1.
  virtual void interpolate(double theta, Eigen::VectorXd& y) const;
  /// Repeats the step last attempted with the shorter length h, without changing what the method remembers.
  /// For states within the step if dense output is too coarse. Returns false if f could not be evaluated.
  virtual bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                         Eigen::VectorXd& out) {
    return attempt(flow, t, h, y, dy, out).evaluated;
  }

  /// Whether stability, not accuracy, limits the steps: the scene is stiff, and implicit methods take longer
  /// steps. Methods without a test return false.
  virtual bool stiff() const { return false; }

  /// Whether the method treats contacts itself within its steps. Otherwise contacts are events of the run.
  virtual bool handles_contacts() const { return false; }
  /// For such a method: the contacts' data of the step last attempted; null before the first step or without
  /// contacts.
  virtual const ContactStep* contact_step() const { return nullptr; }

  /// Why the method cannot simulate this system with this treatment of constraints; null: it can.
  virtual const char* objection(const System& /*system*/, ConstraintTreatment /*treatment*/) const {
    return nullptr;
  }

  /// Memory beyond a few vectors, bytes, for a y of `size` components.
  virtual double bytes(Eigen::Index /*size*/) const { return 0; }

  /// Whether y must continue from step to step unchanged, in the same local coordinates, until reset().
  virtual bool keeps_history() const { return false; }
  /// Saves or restores the history that the method keeps of earlier steps. Returns false if it cannot.
  virtual bool keep(Keeper& /*keeper*/) { return true; }
  /// Forgets earlier steps. Call after an event and after the local coordinates are centred anew.
  virtual void reset() {}

 private:
  double hermite_step_ = 0;
  Eigen::VectorXd hermite_start_, hermite_end_, hermite_start_slope_, hermite_end_slope_;
};

/// The method names that a user may give.
std::vector<std::string> integrator_names();

/// The method of that name. `tolerance` (adaptive methods): largest error per step, relative to error_scale.
/// `spectral_radius`: of generalized_alpha. Fails if there is no such method.
Result<std::unique_ptr<Integrator>> make_integrator(const std::string& name, double tolerance,
                                                    double spectral_radius = 0.8);

/// Whether the named method chooses its own steps; false for an unknown name.
bool method_is_adaptive(const std::string& name);

}  // namespace borelli
