// Time stepping for scenes with many contacts (Moreau, Numerical aspects of the sweeping process, Computer
// Methods in Applied Mechanics and Engineering 177, 1999; Jean, The non-smooth contact dynamics method,
// ibid.). Steps have one length and do not locate impacts; the run divides a step that Certifier::too_long
// rejects. Contacts that the step would close act by impulses, resting and impacting ones alike. The
// velocities satisfy Newton's law of restitution and Coulomb's law of friction, all contacts together
// (contact_solver.hpp). Order 2 between impacts (midpoint rule), 1 over impacts.
//
// Positions: a resting contact presses during the whole step, so its impulse moves the bodies for half of the
// step. An impact acts when the gap closes and moves them for the rest of the step: for g / v, where g and v
// are the gap and its rate that the step's end would have without impulses. Remaining overlaps (contacts
// pushed by others) are removed by the least move in the norm of the mass matrix (the position part of Bruls,
// Acary, Cardona, Simultaneous enforcement of constraints at position and velocity levels in the nonsmooth
// generalized-alpha scheme, CMAME 281, 2014). The energy change of both moves is booked.
#pragma once

#include <memory>
#include <vector>

#include "dynamics/contacts/contact_solver.hpp"
#include "dynamics/contacts/far_pairs.hpp"
#include "dynamics/equations/equations.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/methods/work.hpp"

namespace borelli {

/// Result of the contacts in the last step.
struct ContactStep {
  double length = 0;  ///< s
  /// m, per contact: gap at the step's end; of a contact that does not act, the smallest gap within the step.
  Eigen::VectorXd gap;
  Eigen::VectorXd group_work;  ///< J, work of the contact impulses on each independent group
  /// J, spurious part of `group_work`: energy from position shifts by impacts within the step.
  Eigen::VectorXd group_shift;
  Eigen::VectorXd group_projection;  ///< J, energy change from removing the remaining overlap
  /// N s, three per contact: along the normal and the two tangents; zero if the contact does not act.
  Eigen::VectorXd impulse;
  bool acted = false;      ///< some contact acted
  int passed = -1;         ///< a contact that bodies may have passed through within the step; -1: none
  long impacts = 0;        ///< contacts that closed faster than gravity accelerates in one step
  double impact_loss = 0;  ///< J, energy lost in these impacts
  double unsettled = 0;    ///< residual of the impulse solution, relative to the velocities
  /// Largest accepted residual; it is below the step's own error.
  static constexpr double most_unsettled = 1e-4;
  int unsettled_contact = 0;  ///< the contact with the largest residual
  /// m, per acting contact, before overlaps are removed. `bent`: difference of its gap at the end from that
  /// of a straight path from the middle of the step. `overlap`: its depth.
  Eigen::VectorXd bent, overlap;
};

class MoreauStepping : public Integrator {
 public:
  int order() const override { return 2; }
  bool adaptive() const override { return false; }
  Attempt attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                  Eigen::VectorXd& out) override;
  /// None: velocities jump within the step.
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
    Workspace at;              ///< at the middle of the step: mass matrix and bilateral rows
    ConstraintRows seen, end;  ///< gaps of all contacts: at the middle with their rates; at the end
    FarPairs far;
    /// Rows of constraints whose contacts may act: at the middle, or where overlaps are removed.
    ConstraintRows rows;
    Kinematics landed;
    Articulation links;
    ContactSolver solver;
    ContactProblem problem;  ///< of the acting contacts, as is all that follows
    /// Makes room for this many acting contacts.
    void reserve(int contacts);
    /// nv x 3 columns per contact: directions of normal and tangents; zero columns without tangents.
    Rows J;
    /// As J: velocity changes by unit impulses, times the factor of the mass matrix.
    Rows Y;
    /// Per block of eight columns of Y: the count and list of nonzero rows.
    std::vector<int> touched;
    Eigen::VectorXd before, impulse, plastic;  ///< per direction: m/s at the step's start; N s
    Eigen::VectorXd driven;                    ///< per direction: velocity prescribed by drives, m/s
    Eigen::VectorXd ends;   ///< per contact, m: gap at the step's end without impulses, on a straight path
    Eigen::VectorXd late;   ///< per contact: fraction of the step over which its impulse moves the bodies
    Eigen::VectorXd apart;  ///< per contact, kg m: position impulse along the normal
    std::vector<int> acting;
    std::vector<int> parted;  ///< contacts to separate, if any overlaps
    std::vector<char> acts;   ///< per contact: it acts
    std::vector<char> known;  ///< per constraint: `rows` holds its rows
    Eigen::VectorXd wanted, x, change, shift, moved, slope;
    Eigen::VectorXd response;  ///< velocity change by one impulse along a row, nv
    /// Columns of nv numbers: the velocities at the middle, then the differences from them of those at the
    /// start and of those at the end without impulses.
    RowsOf<double> motions;
    Eigen::VectorXd nothing;  ///< zeros, in place of a missing row
    State state;
    Work work;
  };
  bool meet(Flow& flow, const MotionFlow& motion, double t, double h, const Eigen::VectorXd& y,
            Eigen::VectorXd& out);
  void find_gaps(const MotionFlow& motion, double t, const Eigen::VectorXd& y);
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
  void judge_paths(const System& system, double h, bool sudden);

  std::unique_ptr<Scratch> scratch_;
  ContactStep step_, kept_step_;  ///< step_.impulse is the initial guess of the next step
  Eigen::VectorXd middle_, slope_, landed_, separated_;
  double fall_ = 0;  ///< m/s: velocity change by gravity in one step; slower approaches are not impacts
};

}  // namespace borelli
