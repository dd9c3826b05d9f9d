// compile(): from the scene that a user wrote to the flat System that the engine runs on. Every name is
// resolved and every number checked here, once, so that nothing after it need look at a string.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "dynamics/groups.hpp"
#include "dynamics/system.hpp"

namespace borelli {

namespace {

/// What compile knows of a coordinate by its name.
struct KnownCoordinate {
  int step = -1;  ///< -1: locked
  int nq = 0;
  double value = 0;  ///< of a locked scalar
  std::string solid;
};

class Compiler {
 public:
  explicit Compiler(const Scene& scene) : scene_(scene) {}

  Result<System> run() {
    system_.scene = scene_.name;
    system_.settings = scene_.simulation;
    system_.parameters.gravity = scene_.gravity;
    if (!scene_.gravity.allFinite())
      return bad_use("gravity", "is not a finite vector; expected three numbers, m/s^2");
    if (auto done = order_solids(); !done) return tl::unexpected(done.error());
    system_.bodies.emplace_back();  // the world
    previous_free_.push_back(-1);
    supports_.emplace_back();
    system_.solid_bodies.assign(scene_.solids.size(), 0);
    system_.parameters.solid_poses.resize(scene_.solids.size());
    for (const Solid& solid : scene_.solids) system_.solids.push_back(solid.name);
    for (int index : order_)
      if (auto done = add_solid(index); !done) return tl::unexpected(done.error());
    lay_out_coordinates();
    if (auto done = add_inertials(); !done) return tl::unexpected(done.error());
    if (auto done = check_mass_moved(); !done) return tl::unexpected(done.error());
    if (auto done = add_efforts(); !done) return tl::unexpected(done.error());
    if (auto done = add_constraints(); !done) return tl::unexpected(done.error());
    measure_length();
    return std::move(system_);
  }

 private:
  // ---- the tree ----

  /// Parents before children, else in the scene's own order.
  Result<void> order_solids() {
    for (std::size_t i = 0; i < scene_.solids.size(); ++i) {
      const std::string& name = scene_.solids[i].name;
      if (name.empty()) return bad_use(fmt::format("solid {}", i + 1), "has no name; give it one");
      if (name == world_name)
        return bad_use("solid 'world'", "bears the fixed frame's name; call it something else");
      if (!solid_index_.emplace(name, int(i)).second)
        return bad_use(fmt::format("solid '{}'", name),
                       "there are two solids of this name; names must differ");
    }
    std::vector<int> state(scene_.solids.size(), 0);  // 0 new, 1 on the way, 2 done
    for (std::size_t i = 0; i < scene_.solids.size(); ++i)
      if (auto done = visit(int(i), state); !done) return done;
    return {};
  }

  Result<void> visit(int start, std::vector<int>& state) {
    std::vector<int> way;  // from the solid up to one that is placed
    for (int i = start; state[i] != 2;) {
      const Solid& solid = scene_.solids[i];
      if (state[i] == 1)
        return bad_use(fmt::format("solid '{}'", solid.name),
                       fmt::format("is its own ancestor (its parent is '{}'); close loops by constraints",
                                   solid.parent));
      state[i] = 1;
      way.push_back(i);
      if (solid.parent == world_name) break;
      const auto parent = solid_index_.find(solid.parent);
      if (parent == solid_index_.end())
        return bad_use(
            fmt::format("solid '{}'", solid.name),
            fmt::format("its parent '{}' is not in the scene; there are {}", solid.parent, solid_list()));
      i = parent->second;
    }
    for (auto i = way.rbegin(); i != way.rend(); ++i) {
      state[*i] = 2;
      order_.push_back(*i);
    }
    return {};
  }

  Result<void> add_solid(int index) {
    const Solid& solid = scene_.solids[index];
    const int parent_solid = solid.parent == world_name ? -1 : solid_index_.at(solid.parent);
    const int parent_body = parent_solid < 0 ? 0 : system_.solid_bodies[parent_solid];
    Pose X = parent_solid < 0 ? Pose{} : system_.parameters.solid_poses[parent_solid];
    const int first_step = int(system_.steps.size());
    const int moving = int(std::count_if(solid.switches.begin(), solid.switches.end(), [](const Switch& s) {
      return std::visit([](const auto& kind) { return kind.nv > 0; }, s.kind);
    }));
    int number = 0;  // among those with a coordinate
    for (const Switch& one : solid.switches) {
      const bool has_coordinate = std::visit([](const auto& kind) { return kind.nv > 0; }, one.kind);
      std::string name = one.coordinate;
      if (has_coordinate) ++number;
      if (has_coordinate && name.empty())
        name = moving == 1 ? solid.name : fmt::format("{}.{}", solid.name, number);
      if (auto done = add_switch(solid, one, name, X); !done) return done;
    }
    const int step_count = int(system_.steps.size()) - first_step;
    int body = parent_body;
    if (step_count > 0) {
      body = int(system_.bodies.size());
      Body& added = system_.bodies.emplace_back();
      added.parent = parent_body;
      added.first_step = first_step;
      added.step_count = step_count;
      int last_free = previous_free_[parent_body];
      std::vector<int> support = supports_[parent_body];  // steps, not yet coordinates
      for (int s = first_step; s < first_step + step_count; ++s) {
        support.push_back(s);
        step_body_.push_back(body);
        if (system_.steps[s].drive >= 0) continue;
        step_previous_.resize(system_.steps.size(), -1);
        step_previous_[s] = last_free;
        last_free = s;
      }
      step_previous_.resize(system_.steps.size(), -1);
      previous_free_.push_back(last_free);
      supports_.push_back(std::move(support));
    }
    system_.bodies[body].solids.push_back(index);
    system_.solid_bodies[index] = body;
    system_.parameters.solid_poses[index] = X;
    return {};
  }

  // ---- switches ----

  /// Adds a moving switch as a step, behind the placement X, which then starts anew; or takes one that does
  /// not move into X.
  Result<void> add_switch(const Solid& solid, const Switch& one, const std::string& name, Pose& X) {
    const std::string where = name.empty() ? fmt::format("solid '{}'", solid.name)
                                           : fmt::format("solid '{}', coordinate '{}'", solid.name, name);
    SwitchKind kind = one.kind;
    if (auto done = normalise(kind, where); !done) return done;
    const auto [nq, nv, kind_name, rotates] = std::visit(
        [](const auto& k) { return std::tuple(k.nq, k.nv, std::string(k.kind), k.rotates); }, kind);
    if (nv == 0) {
      if (!one.coordinate.empty() || !one.q.empty() || !one.v.empty() || one.range || one.motion.index() != 0)
        return bad_use(
            where,
            fmt::format("a {} switch has no coordinate: remove its name, q, v, motion and range", kind_name));
      std::visit([&](const auto& k) { k.advance(nullptr, X, nullptr, nullptr); }, kind);
      return {};
    }
    auto q = initial_position(one, nq, where);
    if (!q) return tl::unexpected(q.error());
    if (!one.v.empty() && int(one.v.size()) != nv)
      return bad_use(where,
                     fmt::format("its initial v has {} numbers; a {} takes {}", one.v.size(), kind_name, nv));
    if (auto done = check_finite(one.v, where + ", initial v"); !done) return done;
    if (coordinates_.count(name))
      return bad_use(where, fmt::format("solid '{}' has a coordinate of this name too; names must differ",
                                        coordinates_.at(name).solid));
    if (auto done = check_range(one, nq, *q, where); !done) return done;

    KnownCoordinate known{.step = -1, .nq = nq, .value = nq == 1 ? (*q)[0] : 0, .solid = solid.name};
    if (std::holds_alternative<Locked>(one.motion)) {
      if (std::any_of(one.v.begin(), one.v.end(), [](double x) { return x != 0; }))
        return bad_use(where, "is locked and yet starts with a velocity; remove v, or free the coordinate");
      std::vector<Eigen::Vector3d> scratch(2 * nv);
      std::visit([&](const auto& k) { k.advance(q->data(), X, scratch.data(), scratch.data() + nv); }, kind);
      coordinates_.emplace(name, known);
      return {};
    }
    known.step = int(system_.steps.size());
    coordinates_.emplace(name, known);
    Step step{.nq = nq, .nv = nv, .rotates = rotates};
    CoordinateInfo info{
        .name = name, .kind = kind_name, .solid = solid.name, .q_size = nq, .v_size = nv, .angle = rotates};
    if (const auto* driven = std::get_if<Driven>(&one.motion)) {
      if (auto done = add_drive(*driven, one, nq, nv, *q, where); !done) return done;
      step.drive = int(system_.parameters.drives.size()) - 1;
      step.q = info.q_index = system_.driven_nq;
      step.u = info.v_index = system_.driven_nv;
      system_.driven_nq += nq;
      system_.driven_nv += nv;
      system_.driven.push_back(info);
    } else {
      step.q = info.q_index = system_.nq;
      step.u = info.v_index = system_.nv;
      system_.nq += nq;
      system_.nv += nv;
      if (one.range) system_.ranges.push_back({int(system_.coordinates.size()), *one.range});
      system_.coordinates.push_back(info);
      initial_q_.insert(initial_q_.end(), q->begin(), q->end());
      for (int i = 0; i < nv; ++i) initial_v_.push_back(one.v.empty() ? 0 : one.v[i]);
    }
    system_.steps.push_back(step);
    system_.parameters.placements.emplace_back(X);
    system_.parameters.kinds.push_back(kind);
    X = Pose{};
    return {};
  }

  /// Makes an axis unit, and checks the numbers.
  Result<void> normalise(SwitchKind& kind, const std::string& where) {
    return std::visit(
        [&](auto& k) -> Result<void> {
          if constexpr (requires { k.axis; }) {
            const double length = k.axis.norm();
            if (!std::isfinite(length) || length < 1e-12)
              return bad_use(where, fmt::format("its axis ({}, {}, {}) has no direction", k.axis[0],
                                                k.axis[1], k.axis[2]));
            k.axis /= length;
          }
          if constexpr (requires { k.X_AB; }) {
            if (!is_rigid(k.X_AB)) return bad_use(where, "its pose is not a rotation and a finite place");
          }
          return {};
        },
        kind);
  }

  static bool is_rigid(const Pose& X) {
    return X.p.allFinite() && X.R.allFinite() &&
           (X.R * X.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9 && X.R.determinant() > 0;
  }

  static Result<std::vector<double>> initial_position(const Switch& one, int nq, const std::string& where) {
    std::vector<double> q = one.q;
    if (q.empty()) {
      q.assign(nq, 0);
      if (nq == 4) q[0] = 1;
    }
    if (int(q.size()) != nq)
      return bad_use(where, fmt::format("its initial q has {} numbers; expected {}{}", q.size(), nq,
                                        nq == 4 ? " (a quaternion w, x, y, z)" : ""));
    if (auto done = check_finite(q, where + ", initial q"); !done) return tl::unexpected(done.error());
    if (nq == 4) {
      const double norm = Eigen::Map<Quaternion>(q.data()).norm();
      if (std::abs(norm - 1) > 1e-3)
        return bad_use(where, fmt::format("its initial quaternion has length {:.6g}; expected 1", norm));
      for (double& x : q) x /= norm;
    }
    return q;
  }

  static Result<void> check_range(const Switch& one, int nq, const std::vector<double>& q,
                                  const std::string& where) {
    if (!one.range) return {};
    if (nq != 1) return bad_use(where, "only a translation or a rotation has a range; remove it");
    if (!(one.range->lower <= one.range->upper))
      return bad_use(where, fmt::format("its range runs from {} to {}", one.range->lower, one.range->upper));
    if (std::holds_alternative<Driven>(one.motion))
      return bad_use(where, "is driven by time, and goes where its function says; remove its range");
    if (q[0] < one.range->lower || q[0] > one.range->upper)
      return bad_use(where, fmt::format("starts at {}, outside its range of {} to {}", q[0], one.range->lower,
                                        one.range->upper));
    return {};
  }

  Result<void> add_drive(const Driven& driven, const Switch& one, int nq, int nv,
                         const std::vector<double>& q, const std::string& where) {
    if (int(driven.functions.size()) != nv)
      return bad_use(
          where, fmt::format("is driven by {} functions of time; expected {}", driven.functions.size(), nv));
    for (const TimeFunction& f : driven.functions)
      if (!std::isfinite(at(f, 0).value) || !std::isfinite(at(f, 1).value))
        return bad_use(where, "its function of time gives no finite number");
    if (!one.v.empty() || (nq == 1 && !one.q.empty()))
      return bad_use(where,
                     "is driven: its position and velocity come from its function of time; remove q and v");
    Drive drive{.functions = driven.functions};
    if (nq == 4) drive.initial = Eigen::Map<const Quaternion>(q.data());
    system_.parameters.drives.push_back(drive);
    return {};
  }

  // ---- coordinates ----

  /// Puts the driven coordinates behind the free ones, and lists supports, ancestors and the mass matrix's
  /// pattern.
  void lay_out_coordinates() {
    for (Step& step : system_.steps)
      if (step.drive >= 0) {
        step.q += system_.nq;
        step.u += system_.nv;
      }
    const int size = system_.size();
    std::set<int> pattern;
    for (std::size_t b = 0; b < system_.bodies.size(); ++b) {
      Body& body = system_.bodies[b];
      body.first_support = int(system_.support.size());
      for (int s : supports_[b])
        for (int i = 0; i < system_.steps[s].nv; ++i) system_.support.push_back(system_.steps[s].u + i);
      body.support_count = int(system_.support.size()) - body.first_support;
      const int* support = system_.support.data() + body.first_support;
      int own = 0;
      for (int s = body.first_step; s < body.first_step + body.step_count; ++s) own += system_.steps[s].nv;
      for (int i = body.support_count - own; i < body.support_count; ++i)
        for (int j = 0; j <= i; ++j)
          pattern.insert(std::max(support[i], support[j]) * size + std::min(support[i], support[j]));
    }
    system_.pattern.assign(pattern.begin(), pattern.end());

    std::vector<int> parent(system_.nv, -1);  // of each free coordinate, the free one before it
    for (std::size_t s = 0; s < system_.steps.size(); ++s) {
      const Step& step = system_.steps[s];
      if (step.drive >= 0) continue;
      const int before = step_previous_[s];
      parent[step.u] = before < 0 ? -1 : system_.steps[before].u + system_.steps[before].nv - 1;
      for (int i = 1; i < step.nv; ++i) parent[step.u + i] = step.u + i - 1;
    }
    for (int u = 0; u < system_.nv; ++u) {
      system_.first_ancestor.push_back(int(system_.ancestors.size()));
      for (int i = parent[u]; i >= 0; i = parent[i]) system_.ancestors.push_back(i);
      std::reverse(system_.ancestors.begin() + system_.first_ancestor.back(), system_.ancestors.end());
    }
    system_.first_ancestor.push_back(int(system_.ancestors.size()));
    system_.initial.q = Eigen::Map<Eigen::VectorXd>(initial_q_.data(), system_.nq);
    system_.initial.v = Eigen::Map<Eigen::VectorXd>(initial_v_.data(), system_.nv);
  }

  // ---- inertia ----

  Result<void> add_inertials() {
    system_.parameters.inertials.resize(system_.bodies.size());
    for (std::size_t s = 0; s < scene_.solids.size(); ++s) {
      const std::string where = fmt::format("solid '{}'", scene_.solids[s].name);
      auto inertials = inertials_of(scene_.solids[s]);
      if (!inertials) return tl::unexpected(inertials.error());
      const int body = system_.solid_bodies[s];
      const Pose& X = system_.parameters.solid_poses[s];
      for (const Inertial& inertial : *inertials) {
        if (auto done = check_physical(inertial, where, Extent::may_be_bar_or_point); !done)
          return tl::unexpected(Error{done.error().where, done.error().what, Error::Kind::use});
        system_.parameters.inertials[body] += inertial.expressed_in(X.R, X.p);
        system_.bodies[body].massive = system_.bodies[body].touched = true;
      }
    }
    return {};
  }

  /// Each free coordinate must move some mass.
  Result<void> check_mass_moved() {
    std::vector<char> massive(system_.bodies.size(), 0);  // the body or one that it carries
    for (std::size_t b = system_.bodies.size() - 1; b > 0; --b) {
      if (system_.bodies[b].massive) massive[b] = 1;
      if (massive[b]) massive[system_.bodies[b].parent] = 1;
    }
    for (const CoordinateInfo& info : system_.coordinates) {
      const int body = step_body_[coordinates_.at(info.name).step];
      if (massive[body]) continue;
      return bad_use(
          fmt::format("solid '{}', coordinate '{}'", info.solid, info.name),
          fmt::format("moves no mass: give '{}', or a solid that it carries, an inertial, or lock the "
                      "coordinate",
                      info.solid));
    }
    return {};
  }

  // ---- efforts and constraints ----

  Result<void> add_efforts() {
    std::set<std::string> names;
    for (const Effort& effort : scene_.efforts) {
      auto action = resolve(effort, "effort", names);
      if (!action) return tl::unexpected(action.error());
      system_.efforts.push_back(*action);
      system_.parameters.efforts.push_back(effort);
    }
    return {};
  }

  Result<void> add_constraints() {
    std::set<std::string> names;
    for (const Constraint& constraint : scene_.constraints) {
      auto action = resolve(constraint, "constraint", names);
      if (!action) return tl::unexpected(action.error());
      action->first_row = system_.rows;
      action->row_count = std::visit([](const auto& kind) { return kind.rows; }, constraint.kind);
      system_.rows += action->row_count;
      for (int i = 0; i < action->row_count; ++i) {
        system_.row_names.push_back(action->row_count == 1 ? constraint.name
                                                           : fmt::format("{}[{}]", constraint.name, i));
        system_.row_constraint.push_back(int(system_.constraints.size()));
      }
      system_.constraint_names.push_back(constraint.name);
      system_.constraints.push_back(*action);
      system_.parameters.constraints.push_back(constraint);
      std::visit(
          [](auto& kind) {
            if constexpr (requires { kind.normal; }) kind.normal.normalize();
          },
          system_.parameters.constraints.back().kind);
    }
    return {};
  }

  /// Looks up the solids and coordinates of an effort or a constraint, field by field, and checks its
  /// numbers.
  template <class Thing>
  Result<Action> resolve(const Thing& thing, const char* what, std::set<std::string>& names) {
    if (thing.name.empty())
      return bad_use(fmt::format("{} {}", what, names.size() + 1), "has no name; give it one");
    const std::string where = fmt::format("{} '{}'", what, thing.name);
    if (!names.insert(thing.name).second)
      return bad_use(where, fmt::format("there are two {}s of this name; names must differ", what));
    FieldReader reader{*this, where, {}};
    Action action{.first_site = int(system_.sites.size()),
                  .first_coordinate = int(system_.coordinate_sites.size())};
    std::visit(
        [&](const auto& kind) {
          kind.fields(kind, reader);
          if constexpr (requires { kind.complaint(); }) {
            if (const std::string complaint = kind.complaint(); !complaint.empty() && reader.result)
              reader.result = bad_use(where, complaint);
          }
        },
        thing.kind);
    if (!reader.result) return tl::unexpected(reader.result.error());
    action.site_count = int(system_.sites.size()) - action.first_site;
    action.coordinate_count = int(system_.coordinate_sites.size()) - action.first_coordinate;
    return action;
  }

  struct FieldReader {
    Compiler& compiler;
    std::string where;
    Result<void> result;

    void site(std::string_view field, const std::string& solid) {
      if (!result) return;
      if (solid == world_name) {
        compiler.system_.sites.push_back({0, -1});
        return;
      }
      const auto found = compiler.solid_index_.find(solid);
      if (found == compiler.solid_index_.end()) {
        result =
            bad_use(where, fmt::format("its '{}' is on solid '{}', which is not in the scene; there are {}",
                                       field, solid, compiler.solid_list()));
        return;
      }
      const int body = compiler.system_.solid_bodies[found->second];
      compiler.system_.bodies[body].touched = true;
      compiler.system_.sites.push_back({body, found->second});
    }
    void finite(std::string_view field, bool is_finite) {
      if (result && !is_finite)
        result = bad_use(where, fmt::format("its '{}' is not a finite number", field));
    }

    void operator()(std::string_view field, const SolidPoint& at) {
      finite(field, at.point.allFinite());
      compiler.farthest_ = std::max(compiler.farthest_, at.point.norm());
      site(field, at.solid);
    }
    void operator()(std::string_view field, const SolidName& on) { site(field, on.solid); }
    void operator()(std::string_view field, const CoordinateName& name) {
      if (!result) return;
      auto coordinate = compiler.coordinate_site(name.coordinate);
      if (coordinate)
        compiler.system_.coordinate_sites.push_back(*coordinate);
      else
        result = bad_use(where, fmt::format("its '{}' {}", field, coordinate.error().what));
    }
    template <class T>
    void operator()(std::string_view field, const std::optional<T>& value) {
      if (value)
        (*this)(field, *value);
      else if constexpr (std::is_same_v<T, SolidPoint> || std::is_same_v<T, SolidName>)
        compiler.system_.sites.push_back({-1, -1});
    }
    template <class T>
    void operator()(std::string_view field, const std::vector<T>& values) {
      for (const T& value : values) (*this)(field, value);
    }
    void operator()(std::string_view field, double x) { finite(field, std::isfinite(x)); }
    void operator()(std::string_view field, const Eigen::Vector3d& x) { finite(field, x.allFinite()); }
    void operator()(std::string_view field, const Pose& X) { finite(field, is_rigid(X)); }
    void operator()(std::string_view field, const TimeFunction& f) {
      finite(field, std::isfinite(at(f, 0).value) && std::isfinite(at(f, 1).value));
    }
    void operator()(std::string_view, Axes) {}
  };

  Result<CoordinateSite> coordinate_site(const std::string& name) const {
    const auto found = coordinates_.find(name);
    if (found == coordinates_.end()) {
      std::vector<std::string> names;
      for (const auto& [known, ignored] : coordinates_) names.push_back(known);
      return bad_use(name, fmt::format("is on coordinate '{}', which is not in the scene; there are {}", name,
                                       fmt::join(names, ", ")));
    }
    if (found->second.nq != 1)
      return bad_use(
          name, fmt::format("is on '{}', a ball; expected a translation's or rotation's coordinate", name));
    if (found->second.step < 0) return CoordinateSite{-1, -1, found->second.value};
    const Step& step = system_.steps[found->second.step];
    return CoordinateSite{step.q, step.u, 0};
  }

  // ---- the rest ----

  /// The scene's size: the largest distance that it names.
  void measure_length() {
    double length = farthest_;
    for (const Placement& placement : system_.parameters.placements)
      length = std::max(length, placement.X.p.norm());
    for (const Pose& X : system_.parameters.solid_poses) length = std::max(length, X.p.norm());
    for (const Inertial& inertial : system_.parameters.inertials) {
      if (inertial.mass <= 0) continue;
      length = std::max(length, inertial.centre.norm() + std::sqrt(inertial.tensor.trace() / inertial.mass));
    }
    system_.length = length > 0 ? length : 1;
    find_groups(system_);
    find_lengths(system_);
  }

  static Result<void> check_finite(const std::vector<double>& numbers, const std::string& where) {
    for (double x : numbers)
      if (!std::isfinite(x)) return bad_use(where, "holds something that is not a finite number");
    return {};
  }

  std::string solid_list() const {
    std::vector<std::string> names{world_name};
    for (const Solid& solid : scene_.solids) names.push_back(solid.name);
    return fmt::format("{}", fmt::join(names, ", "));
  }

  const Scene& scene_;
  System system_;
  std::vector<int> order_;
  std::map<std::string, int> solid_index_;
  std::map<std::string, KnownCoordinate> coordinates_;
  std::vector<double> initial_q_, initial_v_;
  std::vector<std::vector<int>> supports_;  ///< steps of each body's chain
  std::vector<int> previous_free_;          ///< the last free step of each body's chain
  std::vector<int> step_previous_, step_body_;
  double farthest_ = 0;
};

}  // namespace

Placement::Placement(const Pose& pose) : X(pose) {
  const bool turned = (pose.R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() != 0;
  const bool shifted = pose.p.cwiseAbs().maxCoeff() != 0;
  form = turned ? Form::general : shifted ? Form::shift : Form::identity;
}

std::string System::group_name(int group) const {
  for (const Body& body : bodies)
    if (&body != bodies.data() && body.group == group && !body.solids.empty()) return solids[body.solids[0]];
  return "";
}

std::string System::velocity_name(int i) const {
  for (const CoordinateInfo& info : coordinates) {
    if (i < info.v_index || i >= info.v_index + info.v_size) continue;
    return info.v_size == 1 ? info.name : fmt::format("{}.{}", info.name, "xyz"[i - info.v_index]);
  }
  return fmt::format("velocity {}", i);
}

Result<System> compile(const Scene& scene) { return Compiler(scene).run(); }

}  // namespace borelli
