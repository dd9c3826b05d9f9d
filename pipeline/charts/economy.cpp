#include "pipeline/charts/economy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "dynamics/numbers/rotation_vector.hpp"
#include "dynamics/run/simulate.hpp"
#include "pipeline/charts/work_precision.hpp"

namespace borelli {
namespace {

constexpr double unknown_number = std::numeric_limits<double>::quiet_NaN();

// motions are computed to the tolerance divided by this
constexpr double margin = 100;

// replaces dop853 if that fails
constexpr const char* stiff_method = "arkode";

// a change whose error exceeds the tolerance by this factor is not tried again
constexpr double hopeless = 10;

// a run is aborted at this multiple of the evaluations of all the whole model's runs together
constexpr double patience = 3;

// share of the whole model's runs in the search's progress
constexpr double first_share = 0.1;

// number of remaining changes that are tried in pairs
constexpr std::size_t paired = 6;

// compared instants per step of the whole model, and their largest number
constexpr double instants_to_a_step = 4;
constexpr int most_instants = 20000;

bool moves(const Switch& one) {
  return !std::holds_alternative<Fixed>(one.kind) && !std::holds_alternative<Locked>(one.motion);
}

/// Coordinates that are locked together.
struct Change {
  std::string words;
  std::vector<std::string> coordinates;
  /// Error at the last trial, with `beside` changes already taken (-1: never tried); NaN: impossible for
  /// `reason`.
  double error = 0;
  int beside = -1;
  std::string reason = {};
  bool pair = false;  ///< of two other changes
};

std::vector<Change> changes_of(const Scene& scene) {
  std::vector<Change> out;
  for (const Solid& solid : scene.solids) {
    Change joint{.words = fmt::format("joint of '{}'", solid.name), .coordinates = {}};
    for (std::size_t i = 0; i < solid.switches.size(); ++i)
      if (moves(solid.switches[i])) joint.coordinates.push_back(coordinate_name(solid, i));
    for (const std::string& name : joint.coordinates)
      out.push_back({.words = fmt::format("coordinate '{}'", name), .coordinates = {name}});
    if (joint.coordinates.size() > 1) out.push_back(std::move(joint));
  }
  return out;
}

/// Whether everything that an effort or constraint names is a coordinate of a set.
struct OnlyNames {
  const std::set<std::string>& locked;
  bool any = false, others = false;

  void note(const std::string& name) {
    any = true;
    others = others || !locked.contains(name);
  }
  void operator()(std::string_view, const CoordinateName& field) { note(field.coordinate); }
  void operator()(std::string_view, const AnyCoordinate& field) { note(field.coordinate); }
  void operator()(std::string_view, const std::vector<CoordinateName>& field) {
    for (const CoordinateName& one : field) note(one.coordinate);
  }
  void operator()(std::string_view, const SolidPoint&) { others = true; }
  void operator()(std::string_view, const SolidName&) { others = true; }
  void operator()(std::string_view, const std::optional<SolidPoint>&) { others = true; }
  void operator()(std::string_view, const std::optional<SolidName>&) { others = true; }
  template <class T>
  void operator()(std::string_view, const T&) {}
};

template <class Action>
bool acts_on_nothing_else(const Action& action, const std::set<std::string>& locked) {
  return std::visit(
      [&]<class Kind>(const Kind& kind) {
        if constexpr (requires(OnlyNames names) { Kind::fields(kind, names); }) {
          OnlyNames names{locked};
          Kind::fields(kind, names);
          return names.any && !names.others;
        } else {
          return false;  // C++, which names nothing
        }
      },
      action.kind);
}

class SmallestModel {
 public:
  SmallestModel(const Scene& scene, const EconomySettings& settings,
                const std::function<void(const std::string&, double)>& progress)
      : scene_(scene), settings_(settings), progress_(progress) {}

  Result<Economy> run() {
    if (!(settings_.tolerance >= 1e-9 && settings_.tolerance <= 1) || settings_.outputs < 1 ||
        settings_.repeats < 1)
      return bad_use("economy",
                     "needs a tolerance from 1e-9 to 1, and at least one output time and one repeat");
    const auto system = compile(scene_);
    if (!system) return tl::unexpected(system.error());
    length_ = system->length;
    out_.scene = scene_.name;
    out_.tolerance = settings_.tolerance;
    out_.accuracy = std::clamp(settings_.tolerance / margin, 1e-11, 0.1);
    if (auto named = name_quantities(); !named) return tl::unexpected(named.error());
    out_.instants = settings_.outputs;
    const double begun = processor_time();
    tell("the whole model", 0, first_share);
    auto full = motion(*system);
    if (full && resolve(*full)) full = motion(*system);
    if (!full)
      return failure(scene_.name,
                     fmt::format("its motion cannot be computed to {:g}, a hundredth of the tolerance: {}",
                                 out_.accuracy, full.error().message()));
    full_ = std::move(*full);
    note_start(*system);
    out_.smallest = scene_;
    add_model("", 0, "", *system);
    const auto rough = rough_motion(*system);  // rows of output may cost more than the steps between
    most_evaluations_ = patience * double(std::max(full_.certificate.evaluations,
                                                   rough ? rough->certificate.evaluations : 0));
    left_ = changes_of(scene_);
    const double all = double(left_.size());
    for (Change* next; (next = choose()) || (pair_up() && (next = choose()));) {
      tell(next->words, first_share + (1 - first_share) * std::max(0., 1 - double(left_.size()) / all),
           (1 - first_share) / all);
      if (next->beside < taken_)
        attempt(*next);
      else
        take(*next);
    }
    for (const Change& one : left_)
      if (!one.pair) out_.refusals.push_back({one.words, one.error, one.reason});
    out_.refusals.insert(out_.refusals.end(), gone_.begin(), gone_.end());
    out_.seconds = processor_time() - begun;
    return std::move(out_);
  }

 private:
  Result<void> name_quantities() {
    if (settings_.quantities.empty()) {
      quantities_ = all_gravity_centres(scene_);
      out_.quantities = {"the gravity centres of all solids"};
      return {};
    }
    for (const std::string& text : settings_.quantities) {
      auto quantity = parse_motion_quantity(text, scene_);
      if (!quantity) return tl::unexpected(quantity.error());
      quantities_.push_back(std::move(*quantity));
      out_.quantities.push_back(text);
    }
    return {};
  }

  /// Increases the number of instants if the motion needs it; answers whether it did.
  bool resolve(const Trajectory& t) {
    std::vector<double> steps = t.step_sizes;
    if (steps.empty()) return false;
    const auto median = steps.begin() + long(steps.size() / 2);  // steps cut at events are far shorter
    std::nth_element(steps.begin(), median, steps.end());
    const double wanted = std::ceil(instants_to_a_step * (t.times.back() - t.times.front()) / *median);
    const int most = std::max(settings_.outputs, most_instants), before = out_.instants;
    out_.sparse = wanted > most;
    out_.instants = std::clamp(int(std::min(wanted, double(most))), before, most);
    return out_.instants > before;
  }

  /// Stores each coordinate's start position, which satisfies constraints and drives.
  void note_start(const System& system) {
    for (const CoordinateInfo& info : full_.coordinates) {
      const Eigen::VectorXd q = full_.q.row(0).segment(info.q_index, info.q_size);
      start_[info.name] = {q.begin(), q.end()};
    }
    for (std::size_t i = 0; i < system.driven.size(); ++i) {
      const CoordinateInfo& info = system.driven[i];
      const auto at = full_.driven_positions.row(0).segment(info.v_index, info.v_size);
      if (info.v_size == 1) {
        start_[info.name] = {at[0]};
        continue;
      }
      const Eigen::Vector3d turn = at.transpose();
      const Quaternion q = product(system.parameters.drives[i].initial, exponential(turn));
      start_[info.name] = {q.begin(), q.end()};
    }
  }

  /// Motion computed to the accuracy.
  Result<Trajectory> motion(const System& system) {
    SimulationSettings how = scene_.simulation;
    how.accuracy = out_.accuracy;
    return simulated(system, how);
  }

  /// Motion by one run, without an error estimate.
  Result<Trajectory> rough_motion(const System& system) {
    SimulationSettings how = single_run();
    auto t = simulated(system, how);
    if (t || how.method == stiff_method) return t;
    how.method = stiff_method;
    return simulated(system, how);
  }

  SimulationSettings single_run() const {
    SimulationSettings how = scene_.simulation;
    how.accuracy = 0;
    how.tolerance = out_.accuracy / 10;
    how.method = std::isnan(full_.certificate.stiff_from) && full_.certificate.method == "dop853"
                     ? "dop853"
                     : stiff_method;
    return how;
  }

  Result<Trajectory> simulated(const System& system, SimulationSettings how) {
    const double start = system.initial.t, length = how.end_time - start;
    how.output_interval = length / out_.instants;
    ++out_.runs;
    Observer observer;
    double reached = 0;  // the farthest of several runs
    observer.progress = [&](double t) {
      reached = std::max(reached, (t - start) / length);
      progress_(now_, done_ + share_ * reached);
      return true;
    };
    observer.limits.evaluations = most_evaluations_;
    auto t = simulate(system, system.initial, how, observer);
    if (t) out_.evaluations += t->certificate.evaluations;
    if (t && !through(*t, how))
      return failure("",
                     fmt::format("takes more than {:.2g} evaluations, {:g} times those of the whole model",
                                 most_evaluations_, patience));
    if (t && !t->certificate.trusted) return failure("", t->certificate.reason);
    return t;
  }

  /// Whether a run reached its end.
  static bool through(const Trajectory& t, const SimulationSettings& how) {
    return t.times.back() >= how.end_time * (1 - 1e-12);
  }

  /// Sets the current task: its start and its share in the search's progress.
  void tell(const std::string& words, double done, double share) {
    now_ = words, done_ = done, share_ = share;
    progress_(words, done);
  }

  Scene with(const Scene& scene, const Change& change) const {
    Scene out = scene;
    const std::set<std::string> now(change.coordinates.begin(), change.coordinates.end());
    std::set<std::string> locked;
    for (Solid& solid : out.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i) {
        Switch& one = solid.switches[i];
        const std::string name = coordinate_name(solid, i);
        if (now.contains(name)) {
          one.motion = Locked{};
          one.q = start_.at(name);
          one.v.clear();
          one.ranges.clear();
          one.armature = 0;
        }
        if (std::holds_alternative<Locked>(one.motion)) locked.insert(name);
      }
    std::erase_if(out.efforts, [&](const auto& e) { return acts_on_nothing_else(e, locked); });
    std::erase_if(out.constraints, [&](const auto& c) { return acts_on_nothing_else(c, locked); });
    return out;
  }

  /// Largest error over quantities and times, and its quantity.
  std::pair<double, std::string> error_of(const Trajectory& t) const {
    std::pair<double, std::string> worst{0, ""};
    for (const MotionQuantity& quantity : quantities_)
      for (std::size_t row = 0; row < std::min(full_.times.size(), t.times.size()); ++row)
        if (const double e = quantity_difference(quantity, full_, t, row, length_); e > worst.first)
          worst = {e, quantity.text};
    return worst;
  }

  /// The next change to try: the one with the smallest error at its last trial, since further locking rarely
  /// reduces an error (accelerated greedy algorithm, Minoux 1978). If even that error is too large, every
  /// change not yet tried beside the current locks. Null: nothing left.
  Change* choose() {
    Change* best = nullptr;
    for (Change& one : left_)
      if (std::isfinite(one.error) && (!best || one.error < best->error)) best = &one;
    if (best && (best->beside < taken_ || best->error <= settings_.tolerance)) return best;
    const auto old =
        std::find_if(left_.begin(), left_.end(), [&](const Change& one) { return one.beside < taken_; });
    return old == left_.end() ? nullptr : &*old;
  }

  /// Adds pairs of the remaining changes with the smallest errors, once per set of locks. Answers whether
  /// there is anything new to try.
  bool pair_up() {
    if (paired_beside_ == taken_) return false;
    paired_beside_ = taken_;
    std::vector<const Change*> singles;
    for (const Change& one : left_)
      if (!one.pair && std::isfinite(one.error)) singles.push_back(&one);
    std::stable_sort(singles.begin(), singles.end(),
                     [](const Change* a, const Change* b) { return a->error < b->error; });
    singles.resize(std::min(singles.size(), paired));
    std::vector<Change> pairs;
    for (std::size_t i = 0; i < singles.size(); ++i)
      for (std::size_t j = i + 1; j < singles.size(); ++j) {
        Change both{.words = singles[i]->words + " and " + singles[j]->words,
                    .coordinates = singles[i]->coordinates,
                    .pair = true};
        const auto& more = singles[j]->coordinates;
        const bool apart = std::none_of(more.begin(), more.end(), [&](const std::string& name) {
          return std::find(both.coordinates.begin(), both.coordinates.end(), name) != both.coordinates.end();
        });
        both.coordinates.insert(both.coordinates.end(), more.begin(), more.end());
        if (apart) pairs.push_back(std::move(both));
      }
    left_.insert(left_.end(), pairs.begin(), pairs.end());
    return !pairs.empty();
  }

  /// Error of a change beside the current locks; `rough`: by one run, otherwise to the accuracy.
  std::pair<double, std::string> tried(Change& change, const Scene& scene, bool rough) {
    const auto system = compile(scene);
    const auto t = !system ? tl::unexpected(system.error()) : rough ? rough_motion(*system) : motion(*system);
    change.beside = taken_;
    change.reason = t ? "" : t.error().message();
    const auto error = t ? error_of(*t) : std::pair(unknown_number, std::string());
    change.error = error.first;
    return error;
  }

  /// Tries a change by one run; drops it if its error is far too large.
  void attempt(Change& change) {
    tried(change, with(out_.smallest, change), true);
    if (!(change.error > hopeless * settings_.tolerance)) return;
    if (!change.pair) gone_.push_back({change.words, change.error});
    left_.erase(left_.begin() + (&change - left_.data()));
  }

  /// Locks the change if its estimated error is within the tolerance.
  void take(Change& change) {
    Scene scene = with(out_.smallest, change);
    const auto error = tried(change, scene, false);
    if (!(error.first <= settings_.tolerance)) return;
    out_.smallest = std::move(scene);
    ++taken_;
    add_model(change.words, error.first, error.second, compile(out_.smallest).value());
    std::vector<std::string> locked = change.coordinates;
    std::erase_if(left_, [](const Change& one) { return one.pair; });
    forget(locked);
  }

  /// Removes locked coordinates from the remaining changes.
  void forget(const std::vector<std::string>& locked) {
    std::vector<Change> left;
    for (Change& one : left_) {
      std::erase_if(one.coordinates, [&](const std::string& name) {
        return std::find(locked.begin(), locked.end(), name) != locked.end();
      });
      // a joint with one coordinate left is the same change as that coordinate
      const bool same = std::any_of(left.begin(), left.end(), [&](const Change& other) {
        return other.coordinates == one.coordinates;
      });
      if (!one.coordinates.empty() && !same) left.push_back(std::move(one));
    }
    left_ = std::move(left);
  }

  void add_model(const std::string& change, double error, const std::string& worst, const System& system) {
    EconomyModel model{.change = change, .error = error, .worst = worst};
    model.coordinates = system.size();
    model.bodies = int(system.bodies.size()) - 1;
    model.rows = system.rows;
    SimulationSettings how = single_run();
    how.output_interval = how.end_time - system.initial.t;
    Observer observer;
    observer.limits.evaluations = most_evaluations_;
    for (const std::string& method : {how.method, std::string(stiff_method)}) {
      how.method = method;
      std::vector<double> seconds;
      for (int repeat = 0; repeat < settings_.repeats; ++repeat) {
        const double start = processor_time();
        const auto t = simulate(system, system.initial, how, observer);
        if (!t || !through(*t, how)) break;
        seconds.push_back(processor_time() - start);
        model.evaluations = t->certificate.evaluations;
      }
      if (seconds.empty()) continue;
      std::nth_element(seconds.begin(), seconds.begin() + long(seconds.size() / 2), seconds.end());
      model.seconds = seconds[seconds.size() / 2];
      break;
    }
    out_.models.push_back(std::move(model));
  }

  const Scene& scene_;
  const EconomySettings& settings_;
  const std::function<void(const std::string&, double)>& progress_;
  std::string now_;              ///< the current task,
  double done_ = 0, share_ = 0;  ///< its start and share in the progress
  double length_ = 1;
  double most_evaluations_ = std::numeric_limits<double>::infinity();  ///< of a run
  Trajectory full_;
  std::map<std::string, std::vector<double>> start_;  ///< positions of the assembled start, by coordinate
  std::vector<MotionQuantity> quantities_;
  std::vector<Change> left_;
  int paired_beside_ = -1;            ///< taken_ when pairs were last made
  int taken_ = 0;                     ///< number of changes in the smallest model
  std::vector<EconomyRefusal> gone_;  ///< not tried again
  Economy out_;
};

}  // namespace

Result<Economy> scene_economy(const Scene& scene, const EconomySettings& settings,
                              const std::function<void(const std::string&, double)>& progress) {
  return SmallestModel(scene, settings, progress).run();
}

}  // namespace borelli
