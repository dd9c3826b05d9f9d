// Observes a simulation and writes its certificate: energy balance, momenta, constraint residuals, counts,
// verdict.
#pragma once

#include "dynamics/constraints/assembly.hpp"
#include "dynamics/equations/momentum.hpp"
#include "dynamics/methods/moreau.hpp"
#include "dynamics/methods/work.hpp"
#include "dynamics/run/singular_watch.hpp"
#include "dynamics/run/step_watch.hpp"

namespace borelli {

/// The running maximum of a quantity, and when it first passed a given limit.
class Climb {
 public:
  void observe(double t, double value);
  double largest() const { return largest_; }
  double time() const { return time_; }  ///< s, when the maximum was reached
  /// s, when the quantity first passed `limit`; exact to a growth of 1 %.
  double since(double limit) const;

  template <class Keeper>
  void keep(Keeper& k) {
    k(largest_, time_);
    k.growing(steps_);
  }

 private:
  double largest_ = 0, time_ = 0;
  /// (time, value), each value over 1 % larger than the one before
  std::vector<std::pair<double, double>> steps_;
};

/// The energy balance of the scene or of one independent group, observed through a run.
struct EnergyBalance {
  Climb drift;             ///< J: change of kinetic and potential energy since the start, less the work
  Climb without_row_work;  ///< J: the same, without the work of constraint rows
  Climb projected;         ///< J: sum of the sizes of energy changes by projections
  double rounding = 0;     ///< J: the part of a drift that rounding explains

  /// `row_work`: the part of `work` done by constraint rows, J; zero while the rows are met.
  void observe(double t, double kinetic, double potential, double work, double row_work);
  /// The drift that is judged: `drift` if it is within `allowed`, J, otherwise the smaller of the two drifts.
  /// With long steps or redundant rows, the work of rows is integrated less accurately than the motion.
  const Climb& judged(double allowed) const {
    return drift.largest() > allowed && without_row_work.largest() < drift.largest() ? without_row_work
                                                                                     : drift;
  }
  /// The change of the balance's error if the next state has this energy after this work, J.
  double changed(double energy, double work) const { return energy - work - start_ - off_; }
  /// The energy exchanged between its forms, J.
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

/// The largest trusted drift relative to the turnover, if the user gives none.
double energy_threshold(const SimulationSettings& settings, bool adaptive, bool steps_contacts = false);

/// Energy change by contacts that their laws do not explain, J (negative: lost).
struct ContactError {
  double now = 0;
  Climb most;  ///< largest absolute value

  template <class Keeper>
  void keep(Keeper& k) {
    k(now, most);
  }
};

class Certifier {
 public:
  /// `threshold`: the largest trusted drift relative to the turnover.
  Certifier(const System& system, const Parameters& parameters, double threshold, const Assembly& assembly);

  /// Observes a state; its equations are solved in `workspace`.
  void observe(const State& state, Workspace& workspace, const Work& work);
  /// Observes a projection that led to a state whose equations are solved in `workspace`.
  void observe_projection(double t, const Projection& projection, const Workspace& workspace);
  /// Observes the state right after an event that changed velocities; observe() has seen the state right
  /// before it. Internal impacts conserve momentum, so the momenta are judged across the event. `own`: a
  /// user's event may be among them and may change the momenta; they are then judged against their values
  /// after the event.
  void pass_event(Workspace& workspace, bool own);
  /// Observes the end of a fixed step, with its accelerations (nv), by a method of that order; `joined` and
  /// `within` as in StepWatch.
  void observe_step(const State& state, const Eigen::VectorXd& a, int order, bool joined,
                    const Eigen::VectorXd* within);
  const StepWatch& step_watch() const { return step_watch_; }
  /// Counts an accepted step from time t; `whole`: it was not shortened to end on an output time.
  void count_step(double t, double h, bool whole);
  void count_rejection() { ++certificate_.steps_rejected; }
  /// The run ends early for this reason.
  void stop(const std::string& reason, double t) { distrust(t, reason); }
  /// Adds a remark that is no reason for distrust.
  void note(const std::string& text) { certificate_.notes.push_back(text); }
  /// Counts an impact and the energy it lost, J.
  void count_impact(double lost) {
    ++certificate_.impacts;
    certificate_.impact_loss += lost;
  }
  /// Observes the overlaps after a step; h: rows of all contacts, open ones included.
  void observe_gaps(double t, const Eigen::VectorXd& h);
  /// Observes the contacts of a step that ended at t, for a method that treats contacts itself.
  void observe_contacts(double t, const ContactStep& step);
  /// Whether such a step of h is too long: it uses more than 5 % of the error the run may have, or cannot be
  /// trusted at all. `energy`: of the independent groups at its end, J, after `work`.
  bool too_long(double h, const ContactStep& step, const Eigen::VectorXd& energy, const Work& work) const;
  /// Records that an explicit method found the scene stiff at time t (s).
  void find_stiff(double t) { certificate_.stiff_from = t; }
  /// The event log so far.
  std::vector<LoggedEvent>& events() { return certificate_.events; }
  /// Records a reason for distrust since time t; only the first one is kept.
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

  /// The certificate with counts and verdict.
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
  double step_squares_ = 0;  ///< s^2, sum over the accepted steps
  bool started_ = false;
  EnergyBalance energy_;
  /// Per independent group.
  struct Group {
    EnergyBalance energy;
    ContactError contacts;
    double mass = 0;           ///< kg
    double touching = 0;       ///< m: largest length scale of contacts that the method treats itself; 0: none
    double largest_speed = 1;  ///< m/s or rad/s, at least 1
    /// The projection that changed the velocities most: its energy change (J), its time (s), the row with the
    /// largest residual.
    double moved_most = 0, moved_time = 0;
    int moved_row = -1;
    template <class Keeper>
    void keep(Keeper& k) {
      k(energy, contacts, largest_speed, moved_most, moved_time);
    }
  };
  std::vector<Group> groups_;
  double last_time_ = 0;
  /// Per constraint: the rows with the largest residuals. `contradicted` names the rows that the first row
  /// above the limit contradicts.
  struct ResidualRows {
    int position = -1, velocity = -1;
    bool reported = false;
    std::string contradicted;
    template <class Keeper>
    void keep(Keeper& k) {
      k(reported, contradicted);
    }
  };
  std::vector<ResidualRows> residual_rows_;
  /// A conserved momentum: values at the start and last, and the part of its drift that rounding explains.
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
  int order_ = 0;  ///< of a fixed-step method; 0: adaptive
};

}  // namespace borelli
