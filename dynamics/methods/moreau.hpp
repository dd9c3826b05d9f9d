// Time stepping for scenes with many contacts (Moreau, Numerical aspects of the sweeping process, Computer
// Methods in Applied Mechanics and Engineering 177, 1999; Jean, The non-smooth contact dynamics method,
// ibid.): steps that look for no moment of impact (of one length; who runs them makes those in parts that
// Certifier::too_long finds). Contacts that the step would close act in it
// by impulses, resting ones like those that meet: velocities keep Newton's law of restitution and Coulomb's
// of friction, all of them at once (contact_solver.hpp). Order 2 between impacts (the midpoint rule), 1 over
// them.
//
// Positions: what rests is pressed on all through the step, so its impulse moves it for half of that. What
// meets within the step has its impulse then, and moves by it for what is left: with the gap g and the
// velocity v that the step's end would have without impulses, for g / v of it. What overlaps all the same (a
// contact that others push) is put apart by the least move, measured by the mass matrix (the positions' part
// of Bruls, Acary, Cardona, Simultaneous enforcement of constraints at position and velocity levels in the
// nonsmooth generalized-alpha scheme, CMAME 281, 2014). What both moves change of the energy is booked.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contacts/contact_solver.hpp"
#include "dynamics/contacts/far_pairs.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/methods/work.hpp"

namespace borelli {

/// What the contacts did in the last step.
struct ContactStep {
  double length = 0;                 ///< s
  Eigen::VectorXd gap;               ///< m, of each contact at the step's end; of those that do not act, the
                                     ///< least in it
  Eigen::VectorXd group_work;        ///< J, of their impulses on each independent group
  Eigen::VectorXd group_shift;       ///< J, what of it is no law's: that impulses move what meets in the step
  Eigen::VectorXd group_projection;  ///< J, of putting apart what still overlapped
  Eigen::VectorXd
      impulse;         ///< N s, of each contact along its normal and the two across; zero: it does not act
  bool acted = false;  ///< whether any of them touched
  int passed = -1;     ///< a contact that the step may have gone through, unseen; -1: none
  long impacts = 0;    ///< contacts that met faster than one step's gravity makes them
  double impact_loss = 0;  ///< J, lost in these
  double unsettled = 0;    ///< what of the velocities the impulses left to settle, in parts of them
  /// So much of it is less than what a step's own error leaves.
  static constexpr double most_unsettled = 1e-4;
  int unsettled_contact = 0;  ///< where most
  /// m, of each contact that acted, before anything is put apart: by how much its gap at the end differs from
  /// the one that a straight way from the middle would have left it; and by how much it overlaps.
  Eigen::VectorXd bent, overlap;
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
    k(step_.length, step_.impulse);
    return true;
  }
  void reset() override { step_.impulse.setZero(); }

 private:
  struct Scratch {
    Scratch(const System& system, Equations equations);
    Workspace at;              ///< the middle of the step: mass matrix and bilateral rows
    ConstraintRows seen, end;  ///< gaps of all contacts: with their rates in its middle, and at its end
    FarPairs far;
    /// Of constraints whose contacts may act: in its middle, or where they are put apart.
    ConstraintRows rows;
    Kinematics landed;
    Articulation links;
    ContactSolver solver;
    ContactProblem problem;  ///< of the contacts that act, as what follows
    /// Room for so many contacts that act.
    void reserve(int contacts);
    Rows J;  ///< nv x three columns each (zero where it has none across): directions
    Rows Y;  ///< the same: what unit impulses change of the velocities, times the mass matrix' factor
    std::vector<int> touched;  ///< of eight columns after the other: rows of Y that are not zero
    Eigen::VectorXd before, impulse, plastic;  ///< of the rows: m/s at the step's start, N s
    Eigen::VectorXd driven;                    ///< of the rows: what drives give of the velocity, m/s
    Eigen::VectorXd ends;   ///< of the contacts, m: their gaps at the end without impulses, if straight
    Eigen::VectorXd late;   ///< of the contacts: for which part of the step their impulses move them
    Eigen::VectorXd apart;  ///< of the contacts, kg m: impulses of position along normals
    std::vector<int> acting;
    std::vector<int> parted;  ///< contacts that are to end apart, where any overlaps
    std::vector<char> acts;   ///< of all contacts
    std::vector<char> known;  ///< of all constraints: whether `rows` has theirs
    Eigen::VectorXd wanted, x, change, shift, moved, slope;
    Eigen::VectorXd held;  ///< of one impulse along a row: its change of the velocities, nv
    /// Velocities (nv) in the middle, and how those at the start and those that the end would have without
    /// impulses differ from them.
    RowsOf<double> motions;
    Eigen::VectorXd nothing;  ///< a row that a contact has not
    State state;
    Work work;
  };
  bool meet(Flow& flow, const MotionFlow& motion, double t, double h, const Eigen::VectorXd& y,
            Eigen::VectorXd& out);
  void look(const MotionFlow& motion, double t, const Eigen::VectorXd& y);
  void find_rows(const System& system, const Kinematics& kinematics, int contact);
  bool find_acting(const MotionFlow& motion, double t, double h);
  bool add_overlapping(const MotionFlow& motion, double t, double h, bool& added);
  void add_acting(const System& system, int contact, double h);
  bool ready_response(const MotionFlow& motion, double t, double h);
  void find_response(const System& system, int rows);
  void hold_bilateral(const System& system, int column);
  void respond(const System& system, const Eigen::VectorXd& impulse, int rows, Eigen::VectorXd& change);
  double work(const Eigen::VectorXd& impulse) const;
  void scale_back(double scale);
  void book(const System& system);
  bool book_powers(Flow& flow, const MotionFlow& motion, double t, double h, const Eigen::VectorXd& y,
                   Eigen::VectorXd& out);
  void move(Flow& flow, const Eigen::VectorXd& shift, Eigen::VectorXd& out);
  bool book_move(const MotionFlow& motion, double t, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                 Eigen::VectorXd& book);
  bool overlaps(const System& system) const;
  void find_normals(const MotionFlow& motion, double t);
  void find_separation(const System& system, int stride);
  bool separate(Flow& flow, const MotionFlow& motion, double t);
  void judge_gaps(const System& system, double h);
  void judge_ways(const System& system, double h, bool sudden);

  std::unique_ptr<Scratch> scratch_;
  ContactStep step_, kept_step_;  ///< (impulses begin where those of the step before were)
  Eigen::VectorXd middle_, slope_, landed_, separated_;
  double fall_ = 0;  ///< m/s: what gravity makes of a velocity in the step; slower approaches are no impacts
};

}  // namespace borelli
