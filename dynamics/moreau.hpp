// Time stepping for scenes with many contacts (Moreau, Numerical aspects of the sweeping process, Computer
// Methods in Applied Mechanics and Engineering 177, 1999; Jean, The non-smooth contact dynamics method,
// ibid.): steps of one length that look for no moment of impact. Contacts that touch or overlap in the middle
// of a step act in it by impulses, resting ones like those that meet: velocities keep Newton's law of
// restitution and Coulomb's of friction, by projected Gauss-Seidel sweeps over all of them. Order 2 between
// impacts (the midpoint rule), 1 over them; what meets at speed u may overlap by h u.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/constraint_solver.hpp"
#include "dynamics/integrator.hpp"
#include "dynamics/scan.hpp"

namespace borelli {

/// What the contacts did in the last step.
struct ContactStep {
  Eigen::VectorXd gap;         ///< m, of each contact in the middle of the step; of those that do not act,
                               ///< the least in it
  Eigen::VectorXd group_work;  ///< J, of their impulses on each independent group
  bool acted = false;          ///< whether any of them touched
  int passed = -1;             ///< a contact that the step may have gone through, unseen; -1: none
  long impacts = 0;            ///< contacts that met faster than one step's gravity makes them
  double impact_loss = 0;      ///< J, lost in these
  double unsettled = 0;        ///< what of the velocities the sweeps left to settle, in parts of them
  int unsettled_contact = 0;   ///< where most
};

class MoreauStepping : public Integrator {
 public:
  int order() const override { return 2; }
  bool adaptive() const override { return false; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  /// None: velocities jump somewhere in the step.
  int dense_order() const override { return 0; }
  bool shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                 Eigen::VectorXd& out) override;
  const ContactStep* contact_step() const override { return scratch_ ? &step_ : nullptr; }
  bool handles_contacts() const override { return true; }
  bool keep(Keeper& k) override {
    k(impulse_);
    return true;
  }
  void reset() override { impulse_.setZero(); }

 private:
  struct Scratch {
    explicit Scratch(const System& system);
    ConstraintRows every;     ///< the rows of all contacts
    ConstraintSolver solver;  ///< of the bilateral ones
    // of the contacts that act, three rows each (zero where it has none across)
    Rows J, response;  ///< rows x nv: directions, and what unit impulses change of the velocities
    Rows G;            ///< J response^T
    Eigen::VectorXd before, free, velocity, impulse, plastic;  ///< of the rows, m/s and N s
    Eigen::VectorXd driven;  ///< of the rows: what drives give of the velocity, m/s
    Eigen::VectorXd target;  ///< of each contact's normal: at least so fast after the step, m/s
    std::vector<int> acting;
    int moved_most = 0;  ///< of `acting`, in the last sweep
    Eigen::VectorXd wanted, correction, moved, slope;
  };
  void find_acting(const MotionFlow& motion, const Eigen::VectorXd& y, const Eigen::VectorXd& out, double h,
                   double least_rebound);
  void find_response(const MotionFlow& motion);
  double sweep(const System& system, const Eigen::VectorXd& target, double scale, Eigen::VectorXd& impulse);
  double work(const Eigen::VectorXd& impulse) const;
  void scale_back(const System& system, double scale);
  void book(const System& system, double least_rebound);
  bool book_powers(Flow& flow, const MotionFlow& motion, double t, double h, const Eigen::VectorXd& y,
                   Eigen::VectorXd& out);

  std::unique_ptr<Scratch> scratch_;
  ContactStep step_, kept_step_;
  Eigen::VectorXd impulse_, kept_impulse_;  ///< of all contacts, in the last step: where the sweeps begin
  Eigen::VectorXd middle_, slope_;
};

}  // namespace borelli
