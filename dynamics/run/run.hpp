// One run with one method: the loop over its steps. Its parts are steps (run_steps.cpp), what happens within
// them (run_between.cpp), and the records in this room's other files.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/certifier.hpp"
#include "dynamics/run/change_watch.hpp"
#include "dynamics/run/checkpoint.hpp"
#include "dynamics/run/contact_events.hpp"
#include "dynamics/run/equal_steps.hpp"
#include "dynamics/run/event_watch.hpp"
#include "dynamics/run/function_watch.hpp"
#include "dynamics/run/output_times.hpp"
#include "dynamics/run/projection_watch.hpp"
#include "dynamics/run/range_events.hpp"
#include "dynamics/run/recorder.hpp"
#include "dynamics/run/samples.hpp"
#include "dynamics/run/simulate.hpp"
#include "dynamics/run/sink_watch.hpp"
#include "dynamics/run/spring_events.hpp"
#include "dynamics/run/step_path.hpp"
#include "dynamics/system/knots.hpp"

namespace borelli {

class Run {
 public:
  /// `own`: the parameters of `system` if this run owns them and springs may change them; else null.
  Run(const System& system, Parameters* own, const State& state, const SimulationSettings& settings,
      const Observer& observer, Integrator& integrator, const RunLimits& limits, Samples* samples);

  Result<Trajectory> run();

  long evaluations() const { return workspace_.evaluations + (probe_ ? probe_->evaluations : 0); }

 private:
  /// Workspace for states between steps.
  Workspace& probe() { return probe_ ? *probe_ : probe_.emplace(system_); }

  /// The kinematics of a state; valid until the next call.
  const Kinematics& landed(const State& state);

  /// Whether the method treats the scene's contacts within its steps.
  bool steps_contacts() const { return integrator_.handles_contacts() && !system_.contacts.empty(); }

  /// Observes the present state and prepares the next step from it.
  Result<void> begin_step();
  /// Shows the end of a fixed step to the certifier; `joined` as in StepWatch.
  void observe_step(bool joined);

  Result<void> advance_evenly(double target);

  /// Makes a step of h, an equal step or a part of it, to time `end`. Returns false if the step must be
  /// divided, as methods that treat contacts may require.
  Result<bool> try_evenly(double end, double h);

  Result<void> advance_adaptively(double target);

  /// The component that limits the step: the method's worst one, or if there is none (or the equations could
  /// not be solved), the one that changes fastest.
  int worst_of(const Attempt& attempt) const;

  /// Fails if the steps shrink to zero or stall.
  Result<void> follow_steps(const Attempt& attempt);

  /// Projects the end of the step of h, at time t, on the constraints.
  Result<void> land(double t, double h);

  /// Whether the step of h given to land() must be divided, for a method that treats contacts itself.
  bool too_long(double h);

  /// The constraint whose function makes the step given to land() too long; empty: none.
  std::string passes_over_function();

  /// Whether the step of h given to land() may skip an event of a torsion spring.
  bool passes_over_springs(double h);

  /// Accepts the step given to land(), up to its first event that changes anything, and books it.
  Result<void> accept(double t, double h, bool whole);

  const char* equations_name() const;

  void show_rows();

  std::string signature() const { return run_signature(system_, start_state_, settings_); }

  /// Saves or restores everything that later steps depend on. Returns false if the method does not support
  /// it.
  bool keep(Keeper& k, RangeEvents& ranges);

  std::string last_event_words() const;

  /// Handles the events of the step; the first one that changes anything ends it.
  Result<void> pass_events(double h);

  /// Solves the equations at a state between steps, books its projection and shows it to the certifier.
  Result<void> check_between(Landing& between);

  /// Records the rows due within the step of h, before time `until`.
  Result<void> record_between(double h, double until);

  /// Takes the samples due within the step of h, before time `until`.
  Result<void> sample_between(double h, double until);

  /// Disturbs the state on the way. If work is done on the scene, the disturbance at the start decays before
  /// the motion may become unstable. Signs follow the Thue-Morse sequence, so that the disturbances hardly
  /// accumulate.
  void disturb();

  /// Records the row at the present state, if one is due.
  Result<void> record_end();

  Result<void> record(const State& state, Workspace& workspace, const Work& work);

  Result<void> check_bounds();

  tl::unexpected<Error> diverged(const Error& error) const;

  tl::unexpected<Error> too_many(const char* what, double most) const;

  /// Judges the steps: notes repeated ones and checks whether they resolved the scene's fastest change in
  /// time.
  void judge_steps();

  const System& system_;
  Parameters* own_;
  const SimulationSettings& settings_;
  const Observer& observer_;
  Integrator& integrator_;
  const RunLimits& limits_;
  Samples* samples_;           ///< null: no samples wanted
  std::size_t disturbed_ = 0;  ///< number of disturbances on the way
  const State start_state_;
  State state_;
  Workspace workspace_;
  std::optional<Workspace> probe_;  ///< see probe(); set if the scene has rows, or at first use
  MotionFlow motion_;
  StepPath path_;
  Recorder recorder_;
  Certifier* certifier_ = nullptr;
  Work work_{system_.groups};
  Landing landing_, between_, row_;
  Eigen::VectorXd y_, dy_, out_;
  double step_;
  ChangeWatch change_;
  long attempts_ = 0, rows_ = 0;
  Knots knots_;  ///< times at which adaptive steps end
  ProjectionWatch leaps_;
  SpringEvents* springs_ = nullptr;  ///< null: no spring events, or springs not owned
  FunctionWatch functions_;
  std::optional<Kinematics> landed_;  ///< see landed(); set at first use
  /// s, longest step to try after one that skipped a feature
  double follow_function_ = std::numeric_limits<double>::infinity();
  SinkWatch sink_;
  OutputTimes outputs_;
  bool stopped_ = false;
  ContactEvents* contacts_ = nullptr;
  bool stiff_ = false;
  bool keeping_ = false;  ///< the method's history continues from the previous step
  EventWatch* watch_ = nullptr;
  RangeEvents* ranges_ = nullptr;
  bool recorded_ = false;  ///< the present state has its row
  EqualSteps even_;
  bool event_passed_ = false;  ///< the present state follows an event that changed it
  Eigen::VectorXd energy_, energy_before_event_;
  double last_event_ = -std::numeric_limits<double>::infinity();
  int events_at_once_ = 0;
};

}  // namespace borelli
