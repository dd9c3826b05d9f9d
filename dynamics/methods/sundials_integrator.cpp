#include "dynamics/methods/sundials_integrator.hpp"

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "dynamics/methods/slope_jacobian.hpp"
#include "dynamics/system/system.hpp"

namespace borelli {

namespace {

constexpr const char* solver_stopped =
    "the equations of an implicit step did not converge at any step size, so the tolerance cannot be met; "
    "take a larger tolerance";
constexpr const char* no_accuracy =
    "the error of a step exceeds the tolerance at any step size, so the run cannot continue; take a larger "
    "tolerance";

// Step proposed to the run: all that is left, because the solver chooses its own steps within it.
constexpr double own_choice = std::numeric_limits<double>::infinity();

// Per step; each rejection shortens it by up to ten, where a transient begins.
constexpr int most_rejections = 20;

// Steps in one shortened step: a stiff stop at its start may swing many times within it.
constexpr long most_in_part = 100000;

Eigen::Map<Eigen::VectorXd> numbers(N_Vector vector) {
  return {N_VGetArrayPointer(vector), N_VGetLength(vector)};
}

/// Data of the solver: vectors, matrix, linear solver, and the flow that it calls back.
struct Base {
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;
  Flow* flow = nullptr;
  double tolerance = 0;
  Eigen::VectorXd state, slope, start_slope, moved;

  Base(Flow& of, double wanted) : flow(&of), tolerance(wanted), state(of.size()), slope(of.size()) {
    SUNContext_Create(nullptr, &context);
    y = N_VNew_Serial(of.size(), context);
    matrix = SUNDenseMatrix(of.size(), of.size(), context);
    if (!y || !matrix) throw std::bad_alloc();
    solver = SUNLinSol_Dense(y, matrix, context);
  }
  Base(const Base&) = delete;
  Base& operator=(const Base&) = delete;
  ~Base() {
    SUNLinSolFree(solver);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }

  static int rhs(double t, N_Vector y, N_Vector dy, void* user) {
    Base& self = *static_cast<Base*>(user);
    self.state = numbers(y);
    if (!self.flow->derivative(t, self.state, self.slope)) return 1;  // a shorter step may succeed
    numbers(dy) = self.slope;
    return 0;
  }
  /// Error weights. The solver's norm is the root mean square of weight times error; the factor sqrt(size)
  /// makes it a bound on each component.
  static int weights(N_Vector, N_Vector weight, void* user) {
    const Base& self = *static_cast<Base*>(user);
    const Eigen::VectorXd& scale = self.flow->error_scale();
    const double root = std::sqrt(double(scale.size()));
    auto w = numbers(weight);
    for (Eigen::Index i = 0; i < scale.size(); ++i)  // an uncontrolled component still needs a weight
      w[i] = std::isfinite(scale[i]) ? root / (self.tolerance * scale[i]) : 1e-20;
    return 0;
  }
  static int jacobian(double t, N_Vector y, N_Vector dy, SUNMatrix J, void* user, N_Vector, N_Vector,
                      N_Vector) {
    Base& self = *static_cast<Base*>(user);
    const Eigen::Index size = self.state.size();
    Eigen::Map<Eigen::MatrixXd> matrix(SUNDenseMatrix_Data(J), size, size);
    matrix.setZero();
    auto acting = matrix.leftCols(acting_components(*self.flow));
    self.state = numbers(y);
    self.start_slope = numbers(dy);
    return slope_jacobian(*self.flow, t, self.state, self.start_slope, self.moved, self.slope, acting) ? 0
                                                                                                       : 1;
  }
  static void quiet(int, const char*, const char*, char*, void*) {}  // return codes report errors
};

Attempt failed(bool accuracy) {
  return {.evaluated = false, .accepted = false, .trouble = accuracy ? no_accuracy : solver_stopped};
}

/// A step too short to advance time.
constexpr Attempt below_rounding{.accepted = false, .next_step = 0};

}  // namespace

struct CvodeBdf::Memory : Base {
  void* cvode = nullptr;
  N_Vector between = nullptr;
  long rejected = 0;
  Memory(Flow& of, double wanted, double t, const Eigen::VectorXd& start) : Base(of, wanted) {
    numbers(y) = start;
    between = N_VClone(y);
    cvode = CVodeCreate(CV_BDF, context);
    CVodeInit(cvode, rhs, t, y);
    CVodeSetErrHandlerFn(cvode, quiet, nullptr);
    CVodeSetUserData(cvode, static_cast<Base*>(this));
    CVodeWFtolerances(cvode, weights);
    CVodeSetLinearSolver(cvode, solver, matrix);
    CVodeSetMaxErrTestFails(cvode, most_rejections);
  }
  ~Memory() {
    CVodeFree(&cvode);
    N_VDestroy(between);
  }
};

CvodeBdf::CvodeBdf(double tolerance) : tolerance_(tolerance) {}
CvodeBdf::~CvodeBdf() = default;
void CvodeBdf::reset() { memory_.reset(); }

const char* CvodeBdf::objection(const System& system, ConstraintTreatment treatment) const {
  return treatment == ConstraintTreatment::projection && system.rows > 0
             ? "uses several earlier steps, which projection would spoil; set constraints to baumgarte"
             : nullptr;
}

Attempt CvodeBdf::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd&,
                          Eigen::VectorXd& out) {
  if (!memory_) {
    memory_ = std::make_unique<Memory>(flow, tolerance_, t, y);
  }
  memory_->flow = &flow;
  CVodeSetStopTime(memory_->cvode, t + h);
  double reached = t;
  const int code = CVode(memory_->cvode, t + h, memory_->y, &reached, CV_ONE_STEP);
  if (code < 0) return failed(code == CV_ERR_FAILURE);
  if (reached <= t) return below_rounding;
  out = numbers(memory_->y);
  from_ = t;
  made_ = reached - t;
  Attempt attempt{.next_step = own_choice, .made = made_};
  long rejected = 0;
  CVodeGetNumErrTestFails(memory_->cvode, &rejected);
  attempt.rejected = int(rejected - memory_->rejected);
  memory_->rejected = rejected;
  return attempt;
}

bool CvodeBdf::prepare_dense(Flow&, double, double, const Eigen::VectorXd&, const Eigen::VectorXd&,
                             const Eigen::VectorXd&) {
  return true;  // CVODE keeps its own history
}

void CvodeBdf::interpolate(double theta, Eigen::VectorXd& y) const {
  CVodeGetDky(memory_->cvode, from_ + theta * made_, 0, memory_->between);
  y = numbers(memory_->between);
}

// ---- ARKODE ----

struct ArkodeDirk::Memory : Base {
  void* arkode = nullptr;
  double start = 0;                              ///< s, start of the step
  const Eigen::VectorXd *from = nullptr, *rate;  ///< the state there and its known slope
  long rejected = 0;
  Memory(Flow& of, double wanted, double t, const Eigen::VectorXd& y0) : Base(of, wanted) {
    numbers(y) = y0;
    arkode = ARKStepCreate(nullptr, slope_at, t, y, context);
    ARKStepSetErrHandlerFn(arkode, quiet, nullptr);
    ARKStepSetUserData(arkode, static_cast<Base*>(this));
    ARKStepWFtolerances(arkode, weights);
    ARKStepSetLinearSolver(arkode, solver, matrix);
    ARKStepSetJacFn(arkode, jacobian);
    ARKStepSetTableNum(arkode, ARKODE_ESDIRK437L2SA_7_3_4, ARKODE_ERK_NONE);
    ARKStepSetMaxErrTestFails(arkode, most_rejections);
    ARKStepSetMaxNumSteps(arkode, most_in_part);
    // Stage equations are solved to 0.01 of the tolerance, or to 1e-9 of the scale if that is tighter.
    ARKStepSetNonlinConvCoef(arkode, std::min(0.01, 1e-9 / wanted));
    ARKStepSetMaxNonlinIters(arkode, 8);
    ARKStepSetStagePredictFn(arkode, lead_on);
    // Slopes of stages are deduced from their states. Evaluated slopes would contain the states' errors times
    // the stiff rates.
    ARKStepSetDeduceImplicitRhs(arkode, SUNTRUE);
  }
  ~Memory() { ARKStepFree(&arkode); }
  /// Predicts the stages, and takes the Jacobian, along the step's first slope. Friction of a contact that
  /// starts to slide has no direction at zero velocity, so the Jacobian at the start is useless however short
  /// the step.
  static int lead_on(double t, N_Vector y, void* user) {
    const Memory& self = static_cast<Memory&>(*static_cast<Base*>(user));
    numbers(y) = *self.from + (t - self.start) * *self.rate;
    return 0;
  }
  static int slope_at(double t, N_Vector y, N_Vector dy, void* user) {
    const Memory& self = static_cast<Memory&>(*static_cast<Base*>(user));
    if (t != self.start || numbers(y) != *self.from) return rhs(t, y, dy, user);
    numbers(dy) = *self.rate;
    return 0;
  }
};

ArkodeDirk::ArkodeDirk(double tolerance) : tolerance_(tolerance) {}
ArkodeDirk::~ArkodeDirk() = default;

int ArkodeDirk::evolve(Flow& flow, double t, double h, const Eigen::VectorXd& y, const Eigen::VectorXd& dy,
                       int how, Eigen::VectorXd& out, double& reached) {
  if (!memory_) memory_ = std::make_unique<Memory>(flow, tolerance_, t, y);
  Memory& m = *memory_;
  m.flow = &flow;
  m.start = t;
  m.from = &y;
  m.rate = &dy;
  numbers(m.y) = y;
  ARKStepReset(m.arkode, t, m.y);
  ARKStepSetInitStep(m.arkode, h);
  // A single step ends at t + h by its length; with a stop time it would not propose the next step.
  if (how == ARK_NORMAL) ARKStepSetStopTime(m.arkode, t + h);
  reached = t;
  const int code = ARKStepEvolve(m.arkode, t + h, m.y, &reached, how);
  out = numbers(m.y);
  if (code < 0) memory_.reset();
  return code;
}

Attempt ArkodeDirk::attempt(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                            const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  double reached = t;
  const int code = evolve(flow, t, h, y, dy, ARK_ONE_STEP, out, reached);
  if (code < 0) return failed(code == ARK_ERR_FAILURE);
  if (reached <= t) return below_rounding;
  Attempt attempt{.made = reached - t};
  ARKStepGetCurrentStep(memory_->arkode, &attempt.next_step);
  long rejected = 0;
  ARKStepGetNumErrTestFails(memory_->arkode, &rejected);
  attempt.rejected = int(rejected - memory_->rejected);
  memory_->rejected = rejected;
  return attempt;
}

bool ArkodeDirk::shortened(Flow& flow, double t, double h, const Eigen::VectorXd& y,
                           const Eigen::VectorXd& dy, Eigen::VectorXd& out) {
  double reached = t;
  return evolve(flow, t, h, y, dy, ARK_NORMAL, out, reached) >= 0;
}

}  // namespace borelli
