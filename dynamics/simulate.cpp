#include "dynamics/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dynamics/certifier.hpp"
#include "dynamics/chart.hpp"
#include "dynamics/evaluate.hpp"
#include "dynamics/fastest_sine.hpp"
#include "dynamics/integrator.hpp"

namespace borelli {

namespace {

// beyond these no scene of solids means anything: the run has diverged
constexpr double largest_number = 1e12;

// Beyond these a run is a slip of the pen: a billion steps of the smallest scene take an hour, ten million
// rows of it some gigabytes.
constexpr double most_steps = 1e9, most_rows = 1e7;

/// The motion as dy/dt = f(t, y), y = (chart coordinates x, velocities v, work of the four powers,
/// work on each independent group).
class Motion : public Flow {
 public:
  Motion(const System& system, const SimulationSettings& settings, Workspace& workspace)
      : system_(system), w_(workspace), q_(system.nq), scale_(size()) {
    handling_.decide_rank = false;
    if (settings.constraints == ConstraintTreatment::baumgarte) {
      handling_.alpha = settings.baumgarte_alpha;
      handling_.beta = settings.baumgarte_beta;
    }
  }

  Eigen::Index size() const override { return 2 * system_.nv + 4 + system_.groups; }
  const Eigen::VectorXd& error_scale() const override { return scale_; }

  /// Centres the chart on a state, fills y and dy there, decides the rank of the constraints for the step to
  /// come.
  Fault start(const State& state, const Work& work, Eigen::VectorXd& y, Eigen::VectorXd& dy) {
    q0_ = state.q;
    y.setZero();
    y.segment(system_.nv, system_.nv) = state.v;
    y.segment<4>(2 * system_.nv) << work.efforts, work.drives, work.constraints, work.violation;
    y.tail(system_.groups) = work.groups;
    set_scale(state);
    handling_.decide_rank = true;
    derivative(state.t, y, dy);
    handling_.decide_rank = false;
    return fault_;
  }

  bool derivative(double t, const Eigen::VectorXd& y, Eigen::VectorXd& dy) override {
    const int n = system_.nv;
    from_chart(system_, q0_.data(), y.data(), q_.data());
    const double* v = y.data() + n;
    fault_ = accelerate(system_, system_.parameters, t, q_.data(), v, handling_, w_);
    if (fault_) return false;
    dy.resize(size());
    chart_rate(system_, y.data(), v, dy.data());
    dy.segment(n, n) = w_.a;
    dy.segment<4>(2 * n) << w_.power.efforts, w_.power.drives, w_.power.constraints, w_.power.violation;
    dy.tail(system_.groups) = w_.group_power;
    return true;
  }

  /// The state and work that y stands for.
  void take(const Eigen::VectorXd& y, State& state, Work& work) const {
    from_chart(system_, q0_.data(), y.data(), state.q.data());
    state.v = y.segment(system_.nv, system_.nv);
    const auto done = y.segment<4>(2 * system_.nv);
    work.efforts = done[0];
    work.drives = done[1];
    work.constraints = done[2];
    work.violation = done[3];
    work.groups = y.tail(system_.groups);
  }

  const Fault& fault() const { return fault_; }
  /// The name of component i of y.
  std::string component(int i) const {
    const int n = system_.nv;
    if (i < 0 || i >= 2 * n) return "the energy balance";
    return fmt::format("{} '{}'", i < n ? "coordinate" : "the velocity of", system_.velocity_name(i % n));
  }

 private:
  /// Angles count against 1 rad, lengths against what the coordinate carries, velocities against these per
  /// second and their own size; work is not controlled.
  void set_scale(const State& state) {
    const int n = system_.nv;
    for (const CoordinateInfo& info : system_.coordinates)
      for (int i = info.v_index; i < info.v_index + info.v_size; ++i) {
        const double unit = system_.velocity_scale[i];
        scale_[i] = info.angle ? unit : std::max(unit, std::abs(state.q[info.q_index]));
        scale_[n + i] = unit + std::abs(state.v[i]);
      }
    scale_.tail(4 + system_.groups).setConstant(std::numeric_limits<double>::infinity());
  }

  const System& system_;
  Workspace& w_;
  RowHandling handling_;
  Fault fault_;
  Eigen::VectorXd q0_, q_, scale_;
};

/// The rows of a trajectory as they come.
class Recorder {
 public:
  explicit Recorder(const System& system) : system_(system) {
    out_.coordinates = system.coordinates;
    out_.solids = system.solids;
    out_.multiplier_names = system.row_names;
    for (const CoordinateInfo& info : system.driven)
      for (int i = 0; i < info.v_size; ++i)
        out_.driven_names.push_back(info.v_size == 1 ? info.name : fmt::format("{}[{}]", info.name, i));
  }

  void record(const State& state, const Workspace& w, const Work& work) {
    out_.times.push_back(state.t);
    append(q_, state.q);
    append(v_, state.v);
    append(a_, w.a);
    append(multipliers_, w.multipliers);
    append(driven_efforts_, w.drive_efforts);
    for (const Drive& drive : system_.parameters.drives)
      for (const TimeFunction& f : drive.functions) driven_positions_.push_back(at(f, state.t).value);
    for (std::size_t s = 0; s < system_.solids.size(); ++s)
      out_.poses.push_back(w.kinematics.bodies[system_.solid_bodies[s]].X *
                           system_.parameters.solid_poses[s]);
    append(gravity_centre_, gravity_centre(w));
    out_.kinetic.push_back(w.terms.kinetic);
    out_.potential.push_back(w.terms.potential);
    out_.work.push_back(work.total());
  }

  void record_step(double t, double h) {
    out_.step_times.push_back(t);
    out_.step_sizes.push_back(h);
  }

  Trajectory finish(Certificate certificate) {
    const auto rows = Eigen::Index(out_.times.size());
    const auto matrix = [rows](const std::vector<double>& numbers) -> Rows {
      return Eigen::Map<const Rows>(numbers.data(), rows, Eigen::Index(numbers.size()) / rows);
    };
    out_.q = matrix(q_);
    out_.v = matrix(v_);
    out_.a = matrix(a_);
    out_.multipliers = matrix(multipliers_);
    out_.driven_efforts = matrix(driven_efforts_);
    out_.driven_positions = matrix(driven_positions_);
    out_.gravity_centre = matrix(gravity_centre_);
    out_.certificate = std::move(certificate);
    return std::move(out_);
  }

 private:
  template <class Vector>
  static void append(std::vector<double>& numbers, const Vector& x) {
    numbers.insert(numbers.end(), x.data(), x.data() + x.size());
  }

  Eigen::Vector3d gravity_centre(const Workspace& w) const {
    double mass = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (std::size_t b = 1; b < system_.bodies.size(); ++b) {
      mass += system_.parameters.inertials[b].mass;
      first += system_.parameters.inertials[b].mass * w.kinematics.bodies[b].g;
    }
    return mass > 0 ? Eigen::Vector3d(first / mass) : first;
  }

  const System& system_;
  Trajectory out_;
  std::vector<double> q_, v_, a_, multipliers_, driven_efforts_, driven_positions_, gravity_centre_;
};

class Run {
 public:
  Run(const System& system, const State& state, const SimulationSettings& settings, const Observer& observer,
      Integrator& integrator)
      : system_(system),
        settings_(settings),
        observer_(observer),
        integrator_(integrator),
        state_(state),
        workspace_(system),
        motion_(system, settings, workspace_),
        recorder_(system),
        y_(motion_.size()),
        dy_(motion_.size()),
        out_(motion_.size()),
        step_(settings.step) {}

  Result<Trajectory> run() {
    auto assembly = assemble(system_, system_.parameters, state_, workspace_);
    if (!assembly) return tl::unexpected(assembly.error());
    workspace_.evaluations = 0;
    Certifier certifier(system_, system_.parameters, threshold(), *assembly);
    certifier_ = &certifier;
    if (const auto sine = fastest_sine(system_, system_.parameters)) {
      sine_ = *sine;
      longest_step_ = longest_step_in_periods * sine->period;
    }
    if (auto done = begin_step(); !done) return tl::unexpected(done.error());
    recorder_.record(state_, workspace_, work_);
    const double start = state_.t, end = settings_.end_time;
    const long outputs = settings_.output_interval > 0
                             ? std::max(1L, long(std::ceil((end - start) / settings_.output_interval - 1e-9)))
                             : 1;
    for (long k = 1; k <= outputs && !stopped_ && end > start; ++k) {
      const double target = k == outputs ? end : start + double(k) * settings_.output_interval;
      auto done = integrator_.adaptive() ? advance_adaptively(target) : advance_evenly(target);
      if (!done) return tl::unexpected(done.error());
      if (settings_.output_interval > 0 || stopped_) recorder_.record(state_, workspace_, work_);
    }
    judge_steps();
    return recorder_.finish(certifier.finish(work_, workspace_.evaluations));
  }

 private:
  /// Looks at the state reached and readies the step from it.
  Result<void> begin_step() {
    if (const Fault fault = motion_.start(state_, work_, y_, dy_))
      return diverged(describe(system_, fault, state_.t));
    if (awaiting_projection_) {
      const auto& terms = workspace_.terms;
      const Eigen::VectorXd jump = terms.group_kinetic + terms.group_potential - energy_before_projection_;
      work_.projection += jump.sum();
      work_.projection_size += std::abs(jump.sum());
      work_.group_projection += jump;
      work_.group_projection_size += jump.cwiseAbs();
      awaiting_projection_ = false;
    }
    certifier_->observe(state_, workspace_, work_);
    return {};
  }

  Result<void> advance_evenly(double target) {
    const double from = state_.t;
    const long steps = std::max(1L, long(std::ceil((target - from) / settings_.step - 1e-9)));
    for (long i = 1; i <= steps && !stopped_; ++i) {
      const double t = state_.t,
                   next = i == steps ? target : from + (target - from) * double(i) / double(steps);
      if (!integrator_.attempt(motion_, t, next - t, y_, dy_, out_).evaluated)
        return diverged(describe(system_, motion_.fault(), t));
      if (auto done = accept(next, next - t, true); !done) return done;
    }
    return {};
  }

  Result<void> advance_adaptively(double target) {
    const double resolution = 16 * std::numeric_limits<double>::epsilon() *
                              std::max(std::abs(settings_.end_time), std::abs(state_.t));
    while (state_.t < target && !stopped_) {
      if (step_ > longest_step_) {
        step_ = longest_step_;
        held_ = true;
      }
      const double t = state_.t, left = target - t;
      // land on the target without a sliver of a step before it
      const bool last = step_ >= left * (1 - 1e-12), whole = !last && step_ <= left / 2;
      const double h = last ? left : whole ? step_ : left / 2;
      const Attempt attempt = integrator_.attempt(motion_, t, h, y_, dy_, out_);
      if (double(++attempts_) > most_steps) return too_many("steps", most_steps);
      if (!attempt.accepted) {
        certifier_->count_rejection();
        step_ = attempt.next_step;
        if (step_ > resolution) continue;
        return failure(
            system_.scene,
            fmt::format("the step fell below {:.3g} s at t = {:.9g} s, for the sake of {}; the motion cannot "
                        "be continued to the tolerance of {:.3g}",
                        resolution, t, motion_.component(attempt.worst), settings_.tolerance));
      }
      // a step cut short says little about the next; do not let it shrink that
      step_ = whole ? attempt.next_step : std::max(step_, attempt.next_step);
      if (auto done = accept(last ? target : t + h, h, whole); !done) return done;
    }
    return {};
  }

  /// Takes the step just made: onto the constraints, into the books.
  Result<void> accept(double t, double h, bool whole) {
    const double from = state_.t;
    motion_.take(out_, state_, work_);
    state_.t = t;
    if (auto done = check_bounds(); !done) return done;
    if (system_.rows > 0 && settings_.constraints == ConstraintTreatment::projection) {
      const Projection projection = project(system_, system_.parameters, state_, workspace_);
      if (projection.fault) return diverged(describe(system_, projection.fault, t));
      if (projection.unreached >= 0)
        return diverged({fmt::format("constraint '{}'", system_.row_names[projection.unreached]),
                         "the step left it so far off that it cannot be put right; take a smaller step"});
      energy_before_projection_ = projection.energy_before;
      awaiting_projection_ = true;
      integrator_.reset();
    }
    certifier_->count_step(from, h, whole);
    recorder_.record_step(from, h);
    longest_made_ = std::max(longest_made_, h);
    if (auto done = begin_step(); !done) return done;
    if (settings_.output_interval <= 0) {
      if (double(++rows_) > most_rows) return too_many("rows of output", most_rows);
      recorder_.record(state_, workspace_, work_);
    }
    if (observer_.progress && !observer_.progress(t)) {
      stopped_ = true;
      certifier_->stop(fmt::format("stopped on request at t = {:.6g} s of {:.6g} s", t, settings_.end_time),
                       t);
    }
    return {};
  }

  Result<void> check_bounds() {
    for (int i = 0; i < system_.nv; ++i) {
      const double x = out_[i], v = state_.v[i];
      if (std::abs(x) < largest_number && std::abs(v) < largest_number) continue;
      return diverged({fmt::format("coordinate '{}'", system_.velocity_name(i)),
                       std::isfinite(v) && std::isfinite(x)
                           ? fmt::format("its velocity has grown to {:.3g}", v)
                           : "it is no longer a finite number"});
    }
    return {};
  }

  tl::unexpected<Error> diverged(const Error& error) const {
    return failure(error.where, fmt::format("{}; the run ends at t = {:.9g} s of {:.6g} s", error.what,
                                            state_.t, settings_.end_time));
  }

  tl::unexpected<Error> too_many(const char* what, double most) const {
    return failure(system_.scene,
                   fmt::format("more than {:.0e} {} were needed to come to t = {:.9g} s of {:.6g} s; shorten "
                               "the run{}",
                               most, what, state_.t, settings_.end_time,
                               settings_.output_interval > 0 ? "" : ", or set an output_interval"));
  }

  /// Whether the steps followed the scene's fastest sine.
  void judge_steps() {
    if (held_)
      certifier_->note(fmt::format("steps were held to {:.4g} s, an eighth of the period of {}",
                                   longest_step_, sine_.name));
    // a whole number of steps between outputs may be off by rounding
    if (longest_made_ > longest_step_ * (1 + 1e-9))
      certifier_->distrust(
          settings_.end_time,
          fmt::format("steps of {:.4g} s cannot follow {}, whose period is {:.4g} s; take steps of at most "
                      "{:.4g} s, an eighth of it",
                      longest_made_, sine_.name, sine_.period, longest_step_));
  }

  double threshold() const {
    if (settings_.energy_threshold > 0) return settings_.energy_threshold;
    // a fixed step promises nothing: a thousandth is what an eye lets pass. A tolerance per step adds up over
    // steps.
    return integrator_.adaptive() ? std::clamp(1e3 * settings_.tolerance, 1e-9, 1e-3) : 1e-3;
  }

  const System& system_;
  const SimulationSettings& settings_;
  const Observer& observer_;
  Integrator& integrator_;
  State state_;
  Workspace workspace_;
  Motion motion_;
  Recorder recorder_;
  Certifier* certifier_ = nullptr;
  Work work_{system_.groups};
  Eigen::VectorXd y_, dy_, out_;
  double step_;
  FastestSine sine_;
  double longest_step_ = std::numeric_limits<double>::infinity();  ///< s, that follows the fastest sine
  double longest_made_ = 0;                                        ///< s, of the accepted ones
  bool held_ = false;                                              ///< a step was cut to longest_step_
  long attempts_ = 0, rows_ = 0;
  bool stopped_ = false;
  bool awaiting_projection_ = false;
  Eigen::VectorXd energy_before_projection_;
};

Result<void> check_settings(const SimulationSettings& settings, double start) {
  const auto refuse = [](const char* name, double found, const char* expected) {
    return bad_use(fmt::format("simulation, {}", name), fmt::format("is {}; expected {}", found, expected));
  };
  if (!std::isfinite(settings.end_time) || settings.end_time < start)
    return refuse("end_time", settings.end_time, "a time (s) not before the start's");
  if (!std::isfinite(settings.step) || settings.step <= 0)
    return refuse("step", settings.step, "a positive time, s");
  if (!std::isfinite(settings.tolerance) || settings.tolerance <= 0)
    return refuse("tolerance", settings.tolerance, "a positive number");
  if (!std::isfinite(settings.output_interval) || settings.output_interval < 0)
    return refuse("output_interval", settings.output_interval, "a time (s), or 0 for every step");
  if (!std::isfinite(settings.baumgarte_alpha) || settings.baumgarte_alpha < 0)
    return refuse("baumgarte_alpha", settings.baumgarte_alpha, "a gain of at least 0, 1/s");
  if (!std::isfinite(settings.baumgarte_beta) || settings.baumgarte_beta < 0)
    return refuse("baumgarte_beta", settings.baumgarte_beta, "a gain of at least 0, 1/s");
  return {};
}

/// Counts that are known beforehand: rows of output, and steps where they are fixed or held by a sine.
Result<void> check_counts(const System& system, double start, const SimulationSettings& settings,
                          bool adaptive) {
  const auto refuse = [](const char* name, double found, double count, const char* of, double most) {
    return bad_use(fmt::format("simulation, {}", name),
                   fmt::format("is {} s, which makes {:.3g} {} up to the end_time; expected at most {:.0e}",
                               found, count, of, most));
  };
  const double span = settings.end_time - start, interval = settings.output_interval;
  if (interval > 0 && span / interval > most_rows)
    return refuse("output_interval", interval, span / interval, "rows of output", most_rows);
  if (!adaptive) {
    if (const double steps = span / settings.step; steps > most_steps)
      return refuse("step", settings.step, steps, "steps", most_steps);
    else if (interval == 0 && steps > most_rows)
      return refuse("step", settings.step, steps, "rows of output (there is no output_interval)", most_rows);
    return {};
  }
  if (const auto sine = fastest_sine(system, system.parameters)) {
    const double steps = span / (longest_step_in_periods * sine->period);
    if (steps > most_steps)
      return bad_use(sine->name,
                     fmt::format("oscillates with a period of {:.3g} s, whose eighths make {:.3g} "
                                 "steps up to the end_time; expected at most {:.0e}",
                                 sine->period, steps, most_steps));
  }
  return {};
}

}  // namespace

Result<Trajectory> simulate(const System& system, const State& state, const SimulationSettings& settings,
                            const Observer& observer) {
  if (auto ok = check_state(system, state); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_settings(settings, state.t); !ok) return tl::unexpected(ok.error());
  auto integrator = make_integrator(settings.method, settings.tolerance);
  if (!integrator) return tl::unexpected(integrator.error());
  if (auto ok = check_counts(system, state.t, settings, (*integrator)->adaptive()); !ok)
    return tl::unexpected(ok.error());
  try {
    return Run(system, state, settings, observer, **integrator).run();
  } catch (const std::exception& thrown) {  // from a user's function
    return failure(system.scene, fmt::format("a user's function threw: {}", thrown.what()));
  }
}

Result<Trajectory> simulate(const System& system) {
  return simulate(system, system.initial, system.settings);
}

}  // namespace borelli
