// Follows a simulation and writes its certificate: energy balance, momenta, constraint residuals, counts,
// verdict.
#pragma once

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/momentum.hpp"
#include "dynamics/methods/moreau.hpp"
#include "dynamics/methods/work.hpp"
#include "dynamics/run/singular_watch.hpp"
#include "dynamics/run/step_watch.hpp"

namespace borelli {

/// A quantity that climbs through a run, and when it passed a limit.
class Climb {
 public:
  void observe(double t, double value);
  double largest() const { return largest_; }
  double time() const { return time_; }  ///< s, of the largest
  double since(double limit) const;      ///< s, when it first passed a limit; later by a hundredth's climb

  template <class Keeper>
  void keep(Keeper& k) {
    k(largest_, time_);
    k.growing(steps_);
  }

 private:
  double largest_ = 0, time_ = 0;
  std::vector<std::pair<double, double>> steps_;  ///< (time, value), each a hundredth larger than that before
};

/// The energy of the scene or of an independent group of it, followed through a run.
struct EnergyBalance {
  Climb drift;             ///< J: change of kinetic and potential energy since the start, less the work
  Climb without_row_work;  ///< J: the same, without the work of constraint rows
  Climb projected;         ///< J: sum of the sizes of energy changes by projections
  double rounding = 0;     ///< J: the part of a drift that may be rounding

  /// `row_work`: the part of `work` done by constraint rows, J; zero while the rows are met.
  void observe(double t, double kinetic, double potential, double work, double row_work);
  /// The drift that counts: `drift` up to `allowed`, J, beyond it the smaller of the two. Over long steps, or
  /// with redundant rows, the work of rows is integrated less exactly than the motion.
  const Climb& judged(double allowed) const {
    return drift.largest() > allowed && without_row_work.largest() < drift.largest() ? without_row_work
                                                                                     : drift;
  }
  /// By how much a state whose energy is `energy` after that work would change what the balance is off by, J.
  double changed(double energy, double work) const { return energy - work - start_ - off_; }
  /// What passed between the forms of energy, J.
  double turnover() const;
  template <class Keeper>
  void keep(Keeper& k) {
    k(drift, without_row_work, projected, rounding, started_, start_, off_, largest_kinetic_, potential_low_,
      potential_high_, work_low_, work_high_);
  }

 private:
  bool started_ = false;
  double start_ = 0, off_ = 0;
  double largest_kinetic_ = 0, potential_low_ = 0, potential_high_ = 0, work_low_ = 0, work_high_ = 0;
};

/// The largest drift relative to what was turned over that is trusted, for lack of the user's own.
double energy_threshold(const SimulationSettings& settings, bool adaptive, bool steps_contacts = false);

/// What contacts have given (or taken: negative) that no law says, J.
struct ContactError {
  double now = 0;
  Climb most;  ///< of its size

  template <class Keeper>
  void keep(Keeper& k) {
    k(now, most);
  }
};

class Certifier {
 public:
  /// `threshold`: the largest drift relative to what was turned over that is trusted.
  Certifier(const System& system, const Parameters& parameters, double threshold, const Assembly& assembly);

  /// Looks at a state whose equations are solved in `workspace`.
  void observe(const State& state, Workspace& workspace, const Work& work);
  /// Looks at what a projection did on the way to a state whose equations are solved in `workspace`.
  void observe_projection(double t, const Projection& projection, const Workspace& workspace);
  /// Takes in the state just after an event that changed velocities, the one last observed being that just
  /// before it. What solids do to each other there leaves their momenta: these are judged on. `own`: it may
  /// have been a user's, which may do anything; they are judged from here on against what it left.
  void pass_event(Workspace& workspace, bool own);
  /// Looks at the state that a step of one length came to, with its accelerations (nv), by a method of that
  /// order; `joined` as StepWatch has it.
  void observe_step(const State& state, const Eigen::VectorXd& a, int order, bool joined);
  /// Counts an accepted step from time t; `whole`: not cut short to land on an output time.
  void count_step(double t, double h, bool whole);
  void count_rejection() { ++certificate_.steps_rejected; }
  /// The run ends before its time, for that reason.
  void stop(const std::string& reason, double t) { distrust(t, reason); }
  /// Something that is worth knowing but no reason for distrust.
  void note(const std::string& text) { certificate_.notes.push_back(text); }
  /// Counts an impact that lost so much energy, J.
  void count_impact(double lost) {
    ++certificate_.impacts;
    certificate_.impact_loss += lost;
  }
  /// Takes in the rows of all contacts, open ones too, after a step: what overlaps.
  void observe_gaps(double t, const Eigen::VectorXd& h);
  /// Takes in what contacts did in a step that ended at t, where the method realises them itself.
  void observe_contacts(double t, const ContactStep& step);
  /// Whether such a step of h is too long: where it alone takes a part (5 %) of what the run may be off by,
  /// or is not to be trusted at all. `energy`: of the independent groups at its end, after `work`, J.
  bool too_long(double h, const ContactStep& step, const Eigen::VectorXd& energy, const Work& work) const;
  /// An explicit method found the scene stiff at time t.
  void find_stiff(double t) { certificate_.stiff_from = t; }
  /// What has happened so far.
  std::vector<LoggedEvent>& events() { return certificate_.events; }
  /// A reason for distrust, true since t; the first one given is kept.
  void distrust(double t, const std::string& reason);

  template <class Keeper>
  void keep(Keeper& k) {
    const int last_row = system_.rows - 1;
    for (Group& group : groups_) k.within(group.moved_row, -1, last_row);
    for (ResidualRows& rows : residual_rows_)
      k.within(rows.position, -1, last_row), k.within(rows.velocity, -1, last_row);
    k(certificate_, step_squares_, started_, energy_, groups_, residual_rows_, last_time_, momenta_,
      singular_, step_watch_, order_);
  }

  /// The verdict, with the counts.
  Certificate finish(const Work& work, long evaluations);

 private:
  void observe_energy(double t, const Workspace& workspace, const Work& work);
  void judge_energy(const Work& work);
  double rounding_of_rest(int group) const;
  double energy_scale(int group) const;
  void judge_residuals();
  std::string group_words(int group) const;
  void observe_momenta(double t, Workspace& workspace);
  void observe_residuals(double t, const State& state, const Workspace& workspace);
  void observe_overlap(double t, const Contact& contact, double gap);
  void judge_steps();
  void note_singular_positions();
  void note_assembly(const Assembly& assembly);

  const System& system_;
  const Parameters& parameters_;
  Certificate certificate_;
  double step_squares_ = 0;  ///< s^2, their sum
  bool started_ = false;
  EnergyBalance energy_;
  /// Of each independent group.
  struct Group {
    EnergyBalance energy;
    ContactError contacts;
    double mass = 0;           ///< kg
    double touching = 0;       ///< m: largest length scale of its impulsive contacts; 0: none
    double largest_speed = 1;  ///< m/s or rad/s, at least 1
    /// The projection that changed its velocities most: by how much energy (J), when (s), and the row that
    /// was the farthest off.
    double moved_most = 0, moved_time = 0;
    int moved_row = -1;
    template <class Keeper>
    void keep(Keeper& k) {
      k(energy, contacts, largest_speed, moved_most, moved_time);
    }
  };
  std::vector<Group> groups_;
  double last_time_ = 0;
  /// Of each constraint: the rows of its worst residuals, and what else is to be said of the first that was
  /// too large: the rows that it contradicts.
  struct ResidualRows {
    int position = -1, velocity = -1;
    bool told = false;
    std::string contradicted;
    template <class Keeper>
    void keep(Keeper& k) {
      k(told, contradicted);
    }
  };
  std::vector<ResidualRows> residual_rows_;
  /// What is conserved: its value at the start and last, and how much of it may be rounding.
  struct Followed {
    ConservedMomentum momentum;
    Eigen::Vector3d start = Eigen::Vector3d::Zero(), last = start;
    double rounding = 0;
    template <class Keeper>
    void keep(Keeper& k) {
      k(start, last, rounding);
    }
  };
  std::vector<Followed> momenta_;
  SingularWatch singular_;
  StepWatch step_watch_;
  int order_ = 0;  ///< of a method whose steps are of one length; 0: they are not
};

}  // namespace borelli
