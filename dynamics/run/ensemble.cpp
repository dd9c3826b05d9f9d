#include "dynamics/run/ensemble.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>
#include <span>

#include "dynamics/equations/evaluate.hpp"
#include "dynamics/methods/batch_flow.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/certifier.hpp"
#include "dynamics/run/settings_check.hpp"
#include "dynamics/run/simulate.hpp"
#include "dynamics/run/sink_watch.hpp"
#include "dynamics/system/border.hpp"
#include "dynamics/system/fastest_change.hpp"
#include "threads/slabs.hpp"

namespace borelli {

namespace {

constexpr int count = Lanes::count;
constexpr const char* methods[] = {"euler", "rk2",  "rk4",  "rk4_adaptive", "dopri5",  "dop853",
                                   "gbs",   "gbs4", "gbs6", "gbs8",         "gauss16", "semi_implicit_euler",
                                   "verlet"};

/// Groups whose work the method controls (see MotionFlow); empty: none.
std::vector<char> controlled_groups(const System& system, const Integrator& integrator) {
  auto counted = groups_of_counted_work(system, system.parameters);
  if (!integrator.adaptive() || std::count(counted.begin(), counted.end(), 1) == 0) counted.clear();
  return counted;
}

/// Tracks each lane's springs: the side of each limit spring's bounds and whether it pushes; the side of the
/// half turn of each torsion spring.
class Springs {
 public:
  explicit Springs(const System& system) : system_(system) {
    for (std::size_t e = 0; e < system.parameters.efforts.size(); ++e) {
      const EffortKind& kind = system.parameters.efforts[e].kind;
      if (std::holds_alternative<LimitSpring>(kind)) limits_.push_back(e);
      if (const auto* torsion = std::get_if<TorsionSpring>(&kind); torsion && torsion->stiffness != 0)
        torsions_.push_back(e);
    }
  }

  /// Calls leave(lane) for every lane in which, since the last call, a spring passed a bound or half a turn,
  /// became slack or taut, or turned too far to tell.
  template <class Leave>
  void find_crossings(const KinematicsOf<Lanes>& kinematics, Leave&& leave) {
    SiteReader<Lanes> reader(system_, system_.parameters, kinematics);
    std::array<bool, count> passed{};  // leave() may call forget()
    std::size_t at = 0;
    for (const std::size_t e : limits_) {
      const auto& spring = std::get<LimitSpring>(system_.parameters.efforts[e].kind);
      reader.turn_to(system_.efforts[e]);
      Eigen::Vector3<Lanes> x, rate;
      if (spring.range.size() == 1) {
        x[0] = reader.position(0);
        rate[0] = reader.rate(0);
      } else {
        x = logarithm(reader.turn(0));
        rate = rotation_vector_rate(x, reader.turn_rate(0));
      }
      for (std::size_t c = 0; c < spring.range.size(); ++c, ++at) {
        if (at == sides_.size()) sides_.emplace_back().fill(unknown);
        for (int lane = 0; lane < count; ++lane) {
          const double value = x[Eigen::Index(c)][lane];
          const int beyond = value > spring.range[c].upper ? 1 : value < spring.range[c].lower ? -1 : 0;
          const bool slack = 1 + spring.dissipation * beyond * rate[Eigen::Index(c)][lane] < 0;
          const int side = slack ? 2 * beyond : beyond;
          passed[lane] |= sides_[at][lane] != unknown && sides_[at][lane] != side;
          sides_[at][lane] = side;
        }
      }
    }
    for (std::size_t n = 0; n < torsions_.size(); ++n) {
      reader.turn_to(system_.efforts[torsions_[n]]);
      QuaternionOf<Lanes> turn =
          std::get<TorsionSpring>(system_.parameters.efforts[torsions_[n]].kind).turned(reader);
      if (n == turns_.size()) {
        turns_.push_back(turn);
        continue;
      }
      const Lanes near = turns_[n].dot(turn);
      turn = choose(near < 0, QuaternionOf<Lanes>(-turn), turn);
      for (int lane = 0; lane < count; ++lane)
        passed[lane] |=
            turn[0][lane] * turns_[n][0][lane] < 0 || std::abs(near[lane]) < std::cos(largest_turn / 2);
      turns_[n] = turn;
    }
    for (int lane = 0; lane < count; ++lane)
      if (passed[lane]) leave(lane);
  }
  void forget() {
    sides_.clear();
    turns_.clear();
  }

 private:
  static constexpr int unknown = 3;
  static constexpr double largest_turn = 2;  // rad, in a step
  const System& system_;
  std::vector<std::size_t> limits_, torsions_;
  std::vector<std::array<int, count>> sides_;  ///< per bound and lane
  std::vector<QuaternionOf<Lanes>> turns_;     ///< per torsion spring
};

/// Asked at every step, by any thread.
using GoOn = std::function<bool()>;

Ending stopped() {
  Ending ending;
  ending.reason = "stopped on request";
  return ending;
}

/// Simulates motions eight at a time; one instance per thread.
class BatchRun {
 public:
  BatchRun(const System& system, const SimulationSettings& settings, std::unique_ptr<Integrator> integrator,
           const std::optional<FastestChange>& change, const GoOn& go_on)
      : system_(system),
        settings_(settings),
        integrator_(std::move(integrator)),
        change_(change),
        go_on_(go_on),
        controlled_(controlled_groups(system, *integrator_)),
        w_(system, !controlled_.empty()),
        flow_(system, w_, controlled_),
        springs_(system),
        state_(system),
        y_(Eigen::VectorXd::Zero(flow_.size())),
        dy_(y_),
        out_(y_) {
    if (change) longest_ = longest_step_in_periods * change->period;
  }

  /// Simulates up to eight motions. Only marks those that simulate() must make; marks all if go_on() returns
  /// false.
  void run(std::span<const Member> members, std::span<Ending> endings) {
    take_in(members);
    for (Ending& ending : endings) ending.alone = false;
    endings_ = endings;
    double step = settings_.step;
    const double start = state_.t, end = settings_.end_time;
    const double resolution =
        16 * std::numeric_limits<double>::epsilon() * std::max(std::abs(end), std::abs(start));
    const double steps = std::max(1.0, std::ceil((end - start) / settings_.step - 1e-9));
    double number = 0;  // of the last fixed step
    while (begin() && state_.t < end) {
      if (!go_on_()) {
        for (Ending& ending : endings) ending.alone = true;
        return;
      }
      const bool adaptive = integrator_->adaptive();
      const double left = end - state_.t;
      const double wanted = std::min(step, longest_);
      const bool last = adaptive ? wanted >= left * (1 - 1e-12) : number + 1 == steps;
      double h = left;
      if (!last)  // land on the end without a tiny last step
        h = adaptive ? std::min(wanted, left / 2) : start + (end - start) * (number + 1) / steps - state_.t;
      const Attempt attempt = integrator_->attempt(flow_, state_.t, h, y_, dy_, out_);
      if (!attempt.evaluated || !attempt.accepted) {
        step = attempt.next_step;
        if (adaptive && step > resolution && !sinks(step, false)) continue;
        leave(attempt);
        step = settings_.step;
        continue;
      }
      // A shortened step says little about the next one; do not let it reduce the proposal.
      if (adaptive) step = h < wanted ? std::max(step, attempt.next_step) : attempt.next_step;
      flow_.take(out_, state_);
      y_ = out_;
      number += 1;
      state_.t = last ? end : state_.t + h;
      for (std::size_t i = 0; i < endings.size(); ++i) ++endings[i].steps;
      longest_made_ = std::max(longest_made_, h);
      leave_beyond_bounds(out_);
      if (adaptive && sinks(step, true)) {
        leave(attempt);
        step = settings_.step;
      }
    }
    for (std::size_t i = 0; i < endings.size(); ++i)
      if (active_[i]) judge(int(i));
  }

 private:
  void take_in(std::span<const Member> members) {
    state_.t = members[0].start.t;
    for (int lane = 0; lane < count; ++lane) {
      const bool there = lane < int(members.size());
      const Member& member = members[there ? lane : 0];
      active_[lane] = there;
      State begun = member.start;
      for (const CoordinateInfo& info : system_.coordinates)
        if (info.q_size == 4) begun.q.segment<4>(info.q_index).normalize();
      state_.set(lane, begun);
      const auto& inertials = member.inertials.empty() ? system_.parameters.inertials : member.inertials;
      for (std::size_t b = 0; b < inertials.size(); ++b) w_.set_inertial(lane, int(b), inertials[b]);
    }
    y_.setZero();
    flow_.begin(state_);
    sink_ = {};
    for (int lane = 0; lane < count; ++lane) flow_.hold(lane, members[active_[lane] ? lane : 0].efforts);
    balances_.assign(std::size_t(system_.groups), {});
    springs_.forget();
    integrator_->reset();
    longest_made_ = 0;
  }

  /// Solves the equations at the present state, checks it and prepares the next step. Returns false if no
  /// lane is left.
  bool begin() {
    for (;;) {
      if (std::none_of(active_.begin(), active_.end(), [](bool on) { return on; })) return false;
      if (!flow_.start(state_, y_, dy_)) {
        for (int lane = 0; lane < count; ++lane)
          if (flow_.failed()[lane]) replace(lane);
        continue;
      }
      left_ = false;
      springs_.find_crossings(w_.kinematics, [&](int lane) { replace(lane); });
      if (!left_) break;
    }
    find_energies(system_, system_.parameters, state_, w_);
    flow_.set_work_scale();
    for (int g = 0; g < system_.groups; ++g)
      for (int lane = 0; lane < count; ++lane)
        balances_[g][lane].observe(state_.t, w_.terms.group_kinetic[g][lane],
                                   w_.terms.group_potential[g][lane], y_[count * (2 * system_.nv + g) + lane],
                                   0);
    return true;
  }

  /// Whether the steps shrink to zero or stall.
  bool sinks(double step, bool accepted) {
    return sink_.after(state_.t, step, accepted, settings_.end_time, most_steps) != SinkWatch::Verdict::fine;
  }

  /// Removes the lanes with a number beyond largest_number, at which simulate() reports divergence.
  void leave_beyond_bounds(const Eigen::VectorXd& y) {
    for (int lane = 0; lane < count; ++lane) {
      bool beyond = false;
      for (Eigen::Index i = lane; i < count * 2 * system_.nv; i += count)
        beyond = beyond || !(std::abs(y[i]) < largest_number);
      if (beyond && active_[lane]) replace(lane);
    }
  }

  /// Removes the lanes that make the step fail.
  void leave(const Attempt& attempt) {
    left_ = false;
    for (int lane = 0; lane < count; ++lane)
      if (!attempt.evaluated && flow_.failed()[lane]) replace(lane);
    if (!left_ && attempt.worst >= 0) replace(attempt.worst % count);
    if (!left_) active_.fill(false);
    sink_ = {};
    for (std::size_t i = 0; i < endings_.size(); ++i) endings_[i].alone = !active_[i];
    integrator_->reset();
  }

  /// Removes a lane; from now on it copies another one.
  void replace(int lane) {
    left_ = true;
    active_[lane] = false;
    if (lane < int(endings_.size())) endings_[lane].alone = true;
    const auto other = std::find(active_.begin(), active_.end(), true) - active_.begin();
    if (other == count) return;
    const auto copy = [&](Lanes& x) { x.set(lane, x[int(other)]); };
    std::for_each(state_.q.begin(), state_.q.end(), copy);
    std::for_each(state_.v.begin(), state_.v.end(), copy);
    for (VariedInertial<Lanes>& inertial : w_.inertials) {
      inertial.set(lane, inertial.lane(int(other)));
      inertial.settle();
    }
    for (Eigen::Index i = 0; i < y_.size(); i += count) y_[i + lane] = y_[i + other];
    flow_.copy_lane(lane, int(other));
    springs_.forget();
    integrator_->reset();
  }

  void judge(int lane) {
    Ending& ending = endings_[lane];
    ending.state = state_.state(lane);
    const double limit = energy_threshold(settings_, integrator_->adaptive());
    ending.trusted = true;
    for (int g = 0; g < system_.groups; ++g) {
      const EnergyBalance& energy = balances_[g][lane];
      const double turnover = energy.turnover(), drift = energy.drift.largest();
      if (turnover > 0) ending.energy_drift = std::max(ending.energy_drift, drift / turnover);
      if (!ending.trusted || drift <= std::max(limit * turnover, energy.rounding)) continue;
      ending.trusted = false;
      ending.reason = fmt::format(
          "the energy balance of '{}' and the solids tied to it has an error of {:.3g} J, {:.2g} of the "
          "{:.3g} J turned over (limit {:.2g})",
          system_.group_name(g), drift, turnover > 0 ? drift / turnover : 0, turnover, limit);
    }
    if (longest_made_ <= longest_ * (1 + 1e-9)) return;
    ending.trusted = false;
    ending.reason = fmt::format(
        "steps of {:.4g} s cannot follow {}, whose {} is {:.4g} s; take steps of at most {:.4g} s",
        longest_made_, change_->name, change_->wave, change_->period, longest_);
  }

  const System& system_;
  const SimulationSettings& settings_;
  std::unique_ptr<Integrator> integrator_;
  const std::optional<FastestChange>& change_;
  const GoOn& go_on_;
  const std::vector<char> controlled_;
  BatchWorkspace w_;
  BatchFlow flow_;
  Springs springs_;
  BatchState state_;
  Eigen::VectorXd y_, dy_, out_;
  std::span<Ending> endings_;
  std::array<bool, count> active_{};
  SinkWatch sink_;
  bool left_ = false;
  /// s, longest step that resolves the scene's functions of time
  double longest_ = std::numeric_limits<double>::infinity();
  double longest_made_ = 0;
  std::vector<std::array<EnergyBalance, count>> balances_;  ///< per group
};

/// A member's constant effort along a coordinate, as an effort of the scene.
struct ConstantEffort {
  Eigen::Vector3d effort;
  bool ball;

  template <class T>
  void apply(EffortPass<T>& pass) const {
    if (ball) {
      const Eigen::Vector3<T> torque = effort.cast<T>();
      pass.turning(0, torque);
      pass.power(torque.dot(pass.turn_rate(0)));
    } else {
      pass.coordinate(0, T(effort[0]));
      pass.power(effort[0] * pass.rate(0));
    }
  }
};

/// The system with these constant efforts added.
System holding(const System& system, const Eigen::VectorXd& efforts) {
  System out = system;
  for (const CoordinateInfo& info : system.coordinates) {
    const auto own = efforts.segment(info.v_index, info.v_size);
    if (own.isZero(0)) continue;
    Eigen::Vector3d effort = Eigen::Vector3d::Zero();
    effort.head(info.v_size) = own;
    out.efforts.push_back({.first_site = int(out.sites.size()),
                           .first_coordinate = int(out.coordinate_sites.size()),
                           .coordinate_count = 1,
                           .group = system.velocity_groups[info.v_index]});
    out.coordinate_sites.push_back({.q = info.q_index, .u = info.v_index});
    out.parameters.efforts.push_back(
        {"constant effort on " + info.name,
         OwnEffort({}, {{info.name}}, ConstantEffort{effort, info.q_size == 4})});
  }
  return out;
}

Ending run_alone(const System& system, const Member& member, const SimulationSettings& settings,
                 const GoOn& go_on) {
  SimulationSettings own = settings;
  own.output_interval = std::max(settings.end_time - member.start.t, 1e-300);
  if (!go_on()) return stopped();
  Observer observer;
  bool goes_on = true;
  observer.progress = [&](double) { return goes_on = go_on(); };
  const auto motion = [&] {
    if (member.inertials.empty() && member.efforts.size() == 0)
      return simulate(system, member.start, own, observer);
    System varied = member.efforts.size() > 0 ? holding(system, member.efforts) : system;
    if (!member.inertials.empty()) varied.parameters.inertials = member.inertials;
    return simulate(varied, member.start, own, observer);
  }();
  if (!goes_on) return stopped();
  Ending ending;
  ending.alone = true;
  if (!motion) {
    ending.reason = fmt::format("{}: {}", motion.error().where, motion.error().what);
    return ending;
  }
  const Eigen::Index last = motion->q.rows() - 1;
  ending.state = {motion->times.back(), motion->q.row(last), motion->v.row(last)};
  ending.trusted = motion->certificate.trusted;
  ending.reason = motion->certificate.reason;
  ending.energy_drift = motion->certificate.energy_turnover > 0
                            ? motion->certificate.energy_drift / motion->certificate.energy_turnover
                            : 0;
  ending.steps = long(motion->step_times.size());
  return ending;
}

Result<void> check(const System& system, const std::vector<Member>& members,
                   const SimulationSettings& settings) {
  if (auto ok = check_batch(system); !ok) return ok;
  if (std::find(std::begin(methods), std::end(methods), settings.method) == std::end(methods))
    return bad_use(fmt::format("method '{}'", settings.method),
                   fmt::format("is not available for ensembles; choose one of {}", fmt::join(methods, ", ")));
  if (settings.accuracy != 0)
    return bad_use("simulation, accuracy",
                   "is not available for ensembles; name a method and a tolerance instead");
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Member& member = members[i];
    const std::string name = fmt::format("member {}", i);
    if (auto ok = check_state(system, member.start); !ok)
      return bad_use(name + ", " + ok.error().where, ok.error().what);
    if (member.start.t != members[0].start.t)
      return bad_use(name,
                     fmt::format("starts at {} s, the first member at {} s; all must start at the same time",
                                 member.start.t, members[0].start.t));
    if (!member.inertials.empty() && member.inertials.size() != system.bodies.size())
      return bad_use(name, fmt::format("has {} inertials; the system has {} bodies", member.inertials.size(),
                                       system.bodies.size()));
    if (member.efforts.size() != 0 && member.efforts.size() != system.nv)
      return bad_use(name, fmt::format("has {} efforts; the system has {} velocities", member.efforts.size(),
                                       system.nv));
    if (!member.efforts.allFinite()) return bad_use(name, "has an effort that is not a finite number");
  }
  return members.empty() ? Result<void>() : check_settings(settings, members[0].start.t);
}

/// Checks the member's inertial elements that differ from the system's.
Result<void> check_inertials(const System& system, const Member& member, std::size_t number) {
  for (std::size_t b = 0; b < member.inertials.size(); ++b) {
    const Inertial &own = member.inertials[b], &given = system.parameters.inertials[b];
    if (own.mass == given.mass && own.centre == given.centre && own.tensor == given.tensor) continue;
    if (auto ok =
            check_physical(own, fmt::format("member {}, body {}", number, b), Extent::may_be_bar_or_point);
        !ok)
      return tl::unexpected(Error{ok.error().where, ok.error().what, Error::Kind::use});
  }
  return {};
}

}  // namespace

Result<std::vector<Ending>> simulate_ensemble(const System& system, const std::vector<Member>& members,
                                              const SimulationSettings& settings, int threads,
                                              const std::function<bool(std::size_t made)>& progress) {
  if (auto ok = check(system, members, settings); !ok) return tl::unexpected(ok.error());
  std::vector<Ending> endings(members.size());
  if (members.empty()) return endings;
  const auto change = fastest_change(system, system.parameters, settings.end_time - members[0].start.t, true);
  const std::size_t batches = (members.size() + count - 1) / count;
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::atomic<std::size_t> refused = members.size();  // the first member that is refused
  Result<void> fine;
  const auto may_run = [&](std::size_t first, std::size_t size) {
    for (std::size_t m = first; m < first + size; ++m)
      if (auto ok = check_inertials(system, members[m], m); !ok) {
        const std::lock_guard lock(mutex);
        if (m < refused) refused = m, fine = ok;
        return false;
      }
    return refused == members.size();
  };
  std::mutex telling;
  std::atomic<std::size_t> made = 0;
  std::atomic<bool> stops = false;
  const GoOn go_on = [&] {
    if (!progress) return true;
    if (const std::unique_lock turn(telling, std::try_to_lock); turn && !stops) stops = !progress(made);
    return !stops;
  };
  const auto work = [&] {
    BatchRun run(system, settings, *make_integrator(settings.method, settings.tolerance), change, go_on);
    for (std::size_t i; (i = next++) < batches;) {
      const std::size_t first = i * count, size = std::min<std::size_t>(count, members.size() - first);
      if (!may_run(first, size)) continue;
      run.run(std::span(members).subspan(first, size), std::span(endings).subspan(first, size));
      for (std::size_t m = first; m < first + size; ++m)
        if (endings[m].alone) endings[m] = run_alone(system, members[m], settings, go_on);
      made += size;
    }
  };
  const auto done = at_border(system, [&]() -> Result<void> {
    in_slabs(std::int64_t(batches), threads, [&](std::int64_t, std::int64_t) { work(); });
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  if (!fine) return tl::unexpected(fine.error());
  if (progress && !stops) progress(made);
  return endings;
}

}  // namespace borelli
