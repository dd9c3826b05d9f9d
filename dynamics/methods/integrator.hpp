// Methods for dy/dt = f(t, y), one step at a time. A new method is one new file beside
// explicit_runge_kutta.cpp that makes an Integrator, and its line in the list of integrator.cpp.
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

/// What is integrated.
class Flow {
 public:
  virtual ~Flow() = default;
  virtual Eigen::Index size() const = 0;
  /// dy <- f(t, y). False: f cannot be evaluated there.
  virtual bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) = 0;
  /// Per component, the size that an error is measured against (adaptive methods); infinity: not controlled.
  virtual const Eigen::VectorXd& error_scale() const = 0;
  /// How many of y's first components are positions, which as many velocities follow; 0: they are not told
  /// apart.
  virtual Eigen::Index positions() const { return 0; }
  /// The positions' part of the derivative alone, which costs little.
  virtual void position_rate(const Eigen::VectorXd& /*y*/, Eigen::VectorXd& /*dy*/) {}
  /// The same of eight states side by side.
  virtual void position_rates(const Eigen::VectorX<Lanes>& /*y*/, Eigen::VectorX<Lanes>& /*dy*/) {}
  /// Whether f is the same at all times, and its slopes at several states cost less side by side than one by
  /// one.
  virtual bool has_lanes() { return false; }
  /// With has_lanes(), lane by lane: dy <- f(y). `states` of the lanes are asked for; each of the others
  /// holds one that can be evaluated. False: f cannot be evaluated at one of them.
  virtual bool derivatives(const Eigen::VectorX<Quad>& /*y*/, int /*states*/, Eigen::VectorX<Quad>& /*dy*/) {
    return false;
  }
  virtual bool derivatives(const Eigen::VectorX<Lanes>& /*y*/, int /*states*/,
                           Eigen::VectorX<Lanes>& /*dy*/) {
    return false;
  }
  /// The flow as the motion of a system, for methods that ask for more than slopes; null: it is none.
  virtual const MotionFlow* motion() const { return nullptr; }
};

/// What came of one attempted step.
struct Attempt {
  bool evaluated = true;          ///< false: f could not be evaluated on the way; `out` means nothing
  bool accepted = true;           ///< false: the error is too large; try again with next_step
  double next_step = 0;           ///< the step that the method proposes, s (a fixed method: the same)
  int worst = -1;                 ///< the component with the largest error, if the method estimates it
  double made = 0;                ///< the step made, s, of a method that chooses it itself (h at most); 0: h
  int rejected = 0;               ///< tries with longer steps, of such a method
  const char* trouble = nullptr;  ///< where it is not f that failed: what did; the run cannot go on
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual int order() const = 0;
  virtual bool adaptive() const = 0;
  /// One step of h from (t, y), where dy = f(t, y) is known: `out` is y at t + h. May keep memory between
  /// steps.
  virtual Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                          Eigen::VectorXd& out) = 0;

  /// A step to try first, from f and how it changes, where only the method's tolerance says how long it may
  /// be; 0: the method has no such thing, or nothing moves. Evaluates f once.
  virtual double first_step(Flow& /*flow*/, double /*t*/, const Eigen::VectorXd& /*y*/,
                            const Eigen::VectorXd& /*dy*/) {
    return 0;
  }

  /// Dense output's order: its error over a step goes as h^(dense_order() + 1). Unless a method has its own,
  /// it is the cubic through the values and slopes at both ends (Hermite's), of order 3.
  virtual int dense_order() const { return 3; }
  /// Whether dense output is as good as the steps themselves, whose errors add up to h^order().
  bool dense_suffices() const { return dense_order() + 1 >= order(); }
  /// Readies interpolate() over the step from (t, y) last attempted, which ended in `out`. False: f could not
  /// be evaluated.
  virtual bool prepare_dense(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& dy, const Eigen::VectorXd& out);
  /// y at t + theta h of that step, theta from 0 to 1.
  virtual void interpolate(double theta, Eigen::VectorXd& y) const;
  /// The step last attempted made again, but only h long, and without a trace in what the method remembers:
  /// for states within it where dense output does not suffice. False: f could not be evaluated.
  virtual bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                         Eigen::VectorXd& out) {
    return attempt(flow, t, h, y, dy, out).evaluated;
  }

  /// Whether its steps have shown that stability bounds them rather than accuracy: a stiff scene, for which
  /// implicit methods take longer ones. Methods without a test for it never say so.
  virtual bool stiff() const { return false; }

  /// Whether it realises the contacts of a scene itself, step by step; else they are events of the run.
  virtual bool handles_contacts() const { return false; }
  /// Of such a method: what they did in the step last attempted; null before the first, or without contacts.
  virtual const ContactStep* contact_step() const { return nullptr; }

  /// Why it cannot simulate a system whose constraints are so treated; null: it can.
  virtual const char* objection(const System& /*system*/, ConstraintTreatment /*treatment*/) const {
    return nullptr;
  }

  /// Memory beyond a few vectors, bytes, for a y of `size` components.
  virtual double bytes(Eigen::Index /*size*/) const { return 0; }

  /// Whether y must go on from step to step as the method left it, in the same local coordinates, until
  /// reset().
  virtual bool keeps_history() const { return false; }
  /// Puts away or fills in what it remembers of earlier steps. False: that cannot be.
  virtual bool keep(Keeper& /*keeper*/) { return true; }
  /// Forgets what it remembers of earlier steps: after an event, or when the local coordinates are centred
  /// anew.
  virtual void reset() {}

 private:
  double hermite_step_ = 0;
  Eigen::VectorXd hermite_start_, hermite_end_, hermite_start_slope_, hermite_end_slope_;
};

/// The methods that a user may name.
std::vector<std::string> integrator_names();

/// The method of that name; `tolerance` is for adaptive ones: the largest error per step, relative to
/// error_scale; `spectral_radius` for generalized_alpha.
Result<std::unique_ptr<Integrator>> make_integrator(const std::string& name, double tolerance,
                                                    double spectral_radius = 0.8);

/// Whether that method chooses its own steps; false too where no method has that name.
bool method_is_adaptive(const std::string& name);

}  // namespace borelli
