#include "dynamics/system/action_sites.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/system/solid_order.hpp"
#include "error/printable.hpp"

namespace borelli {

struct ActionSites::FieldVisitor {
  ActionSites& sites;
  std::string where;
  Result<void> result;

  void site(std::string_view field, const std::string& solid) {
    if (!result) return;
    if (solid == world_name) {
      sites.system_.sites.push_back({0, -1});
      return;
    }
    const auto found = sites.solids_.find(solid);
    if (found == sites.solids_.end()) {
      result =
          bad_use(where, fmt::format("its '{}' is on solid '{}', which is not in the scene; choose from {}",
                                     field, solid, solid_list(sites.scene_)));
      return;
    }
    const int body = sites.system_.solid_bodies[found->second];
    sites.system_.bodies[body].touched = true;
    sites.system_.sites.push_back({body, found->second});
  }
  void finite(std::string_view field, bool is_finite) {
    if (result && !is_finite) result = bad_use(where, fmt::format("its '{}' is not a finite number", field));
  }

  void operator()(std::string_view field, const SolidPoint& at) {
    finite(field, at.point.allFinite());
    sites.farthest_ = std::max(sites.farthest_, at.point.norm());
    site(field, at.solid);
  }
  void operator()(std::string_view field, const SolidName& on) { site(field, on.solid); }
  void operator()(std::string_view field, const CoordinateName& name) {
    coordinate(field, name.coordinate, false);
  }
  void operator()(std::string_view field, const AnyCoordinate& name) {
    coordinate(field, name.coordinate, true);
  }
  void coordinate(std::string_view field, const std::string& name, bool may_be_ball) {
    if (!result) return;
    const auto known = sites.coordinate(name);
    if (!known)
      result = bad_use(where, fmt::format("its '{}' {}", field, known.error().what));
    else if ((*known)->nq != 1 && !may_be_ball)
      result =
          bad_use(where, fmt::format("its '{}' is on '{}', which has three velocities; expected a coordinate "
                                     "with one",
                                     field, name));
    else
      sites.system_.coordinate_sites.push_back(sites.site_of(**known));
  }
  template <class T>
  void operator()(std::string_view field, const std::optional<T>& value) {
    if (value)
      (*this)(field, *value);
    else if constexpr (std::is_same_v<T, SolidPoint> || std::is_same_v<T, SolidName>)
      sites.system_.sites.push_back({-1, -1});
  }
  template <class T>
  void operator()(std::string_view field, const std::vector<T>& values) {
    for (const T& value : values) (*this)(field, value);
  }
  void operator()(std::string_view field, double x) { finite(field, std::isfinite(x)); }
  void operator()(std::string_view field, const Eigen::Vector3d& x) { finite(field, x.allFinite()); }
  void operator()(std::string_view field, const Pose& X) { finite(field, is_rigid(X)); }
  void operator()(std::string_view field, const TimeFunction& f) {
    if (const std::string bad = complaint_of(f); result && !bad.empty())
      result = bad_use(where, fmt::format("its '{}': {}", field, bad));
  }
  void operator()(std::string_view field, const Range& range) {
    finite(field, std::isfinite(range.lower) && std::isfinite(range.upper));
  }
  void operator()(std::string_view field, const Shape& shape) {  // (their sizes: see complaint)
    finite(field, shape.position.allFinite() && shape.orientation.coeffs().allFinite());
    sites.farthest_ = std::max(sites.farthest_, shape.position.norm());
  }
  void operator()(std::string_view, Axes) {}
  void operator()(std::string_view, bool) {}
};

Result<void> ActionSites::add_efforts() {
  std::set<std::string> names;
  for (const Effort& effort : scene_.efforts) {
    auto action = resolve(effort, "effort", names);
    if (!action) return tl::unexpected(action.error());
    system_.efforts.push_back(*action);
    system_.parameters.efforts.push_back(effort);
    const std::string complaint = std::visit(
        [this](auto& kind) -> std::string {
          if constexpr (requires { kind.settle(1, {}); }) {
            const KnownCoordinate& on = **coordinate(kind.on.coordinate);
            return kind.settle(on.nq == 4 ? 3 : on.nq, on.ranges);
          }
          return "";
        },
        system_.parameters.efforts.back().kind);
    if (!complaint.empty())
      return bad_use(fmt::format("{}effort '{}'", scene_.place(effort.line), effort.name), complaint);
  }
  return {};
}

namespace {

/// Adds the contacts of the constraint added last.
void add_contacts(int rows, int contact_rows, System& system) {
  const std::string& name = system.constraint_names.back();
  for (int first = 0; first < rows; first += contact_rows) {
    Contact& contact = system.contacts.emplace_back();
    contact.constraint = int(system.constraints.size()) - 1;
    contact.row = system.constraints.back().first_row + first;
    contact.tangents = contact_rows == 3;
    contact.name = rows == contact_rows ? name : fmt::format("{}[{}]", name, first / contact_rows);
  }
}

/// Normalises directions.
struct Normaliser {
  void operator()(std::string_view field, Eigen::Vector3d& x) const {
    if (is_direction(field)) x.normalize();
  }
  template <class T>
  void operator()(std::string_view, T&) const {}
};

}  // namespace

Result<void> ActionSites::add_constraints() {
  std::set<std::string> names;
  for (const Constraint& constraint : scene_.constraints) {
    auto action = resolve(constraint, "constraint", names);
    if (!action) return tl::unexpected(action.error());
    action->first_row = system_.rows;
    action->row_count = row_count(constraint.kind);
    system_.rows += action->row_count;
    for (int i = 0; i < action->row_count; ++i) {
      system_.row_names.push_back(action->row_count == 1 ? constraint.name
                                                         : fmt::format("{}[{}]", constraint.name, i));
      system_.row_constraint.push_back(int(system_.constraints.size()));
      system_.kinematic_rows.push_back(i >= action->row_count - kinematic_row_count(constraint.kind));
    }
    system_.constraint_names.push_back(constraint.name);
    system_.constraints.push_back(*action);
    system_.parameters.constraints.push_back(constraint);
    std::visit(
        [this](auto& kind) {
          kind.fields(kind, Normaliser{});
          if constexpr (requires { kind.prepare(); }) kind.prepare();
          if constexpr (Unilateral<std::decay_t<decltype(kind)>>)
            add_contacts(system_.constraints.back().row_count, kind.contact_rows, system_);
        },
        system_.parameters.constraints.back().kind);
  }
  return {};
}

/// Looks up the solids and coordinates of an effort or a constraint, field by field, and checks its
/// numbers.
template <class Thing>
Result<Action> ActionSites::resolve(const Thing& thing, const char* what, std::set<std::string>& names) {
  if (thing.name.empty())
    return bad_use(fmt::format("{}{} {}", scene_.place(thing.line), what, names.size() + 1),
                   "has no name; give it one");
  const std::string where = fmt::format("{}{} '{}'", scene_.place(thing.line), what, thing.name);
  if (!names.insert(thing.name).second)
    return bad_use(where, fmt::format("there are two {}s of this name; names must differ", what));
  FieldVisitor reader{*this, where, {}};
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

Result<const KnownCoordinate*> ActionSites::coordinate(const std::string& name) const {
  const auto found = coordinates_.find(name);
  if (found != coordinates_.end()) return &found->second;
  std::vector<std::string> names;
  for (const auto& [known, ignored] : coordinates_) names.push_back(known);
  return bad_use(name, fmt::format("is on coordinate '{}', which is not in the scene; choose from {}", name,
                                   name_list(names)));
}

CoordinateSite ActionSites::site_of(const KnownCoordinate& known) const {
  if (known.step < 0) return {.value = known.value, .turn = known.turn};
  return {.q = system_.steps[known.step].q, .u = system_.steps[known.step].u};
}

}  // namespace borelli
