#include "dynamics/system/groups.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/system/joined_sets.hpp"

namespace borelli {

namespace {

/// Per extended velocity component, the first body that it moves.
std::vector<int> velocity_bodies(const System& system) {
  std::vector<int> bodies(system.size(), 0);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s)
      for (int i = 0; i < system.steps[s].nv; ++i) bodies[system.steps[s].u + i] = int(b);
  }
  return bodies;
}

/// The moving bodies that an effort or constraint acts on.
std::vector<int> bodies_of(const System& system, const Action& action,
                           const std::vector<int>& velocity_body) {
  std::vector<int> bodies;
  for (int i = action.first_site; i < action.first_site + action.site_count; ++i)
    if (system.sites[i].body > 0) bodies.push_back(system.sites[i].body);
  for (int i = action.first_coordinate; i < action.first_coordinate + action.coordinate_count; ++i)
    if (system.coordinate_sites[i].u >= 0) bodies.push_back(velocity_body[system.coordinate_sites[i].u]);
  return bodies;
}

/// Collects the points and lengths that an effort or constraint names.
struct FieldLengths {
  const System& system;
  const Action& action;
  std::vector<double>& bodies;
  int site = 0;
  double own = 0;  ///< the distance that the constraint keeps

  void operator()(std::string_view, const SolidPoint& at) {
    const Site& s = system.sites[action.first_site + site++];
    if (s.body <= 0) return;
    const Eigen::Vector3d p = s.solid < 0 ? at.point : system.parameters.solid_places[s.solid] * at.point;
    bodies[s.body] = std::max(bodies[s.body], p.norm());
  }
  void operator()(std::string_view, const SolidName&) { ++site; }
  template <class T>
  void operator()(std::string_view field, const std::optional<T>& value) {
    if (value)
      (*this)(field, *value);
    else if constexpr (!std::is_same_v<T, double>)
      ++site;
  }
  void operator()(std::string_view field, const std::vector<SolidPoint>& points) {
    for (const SolidPoint& point : points) (*this)(field, point);
  }
  void operator()(std::string_view field, const TimeFunction& f) {
    if (field == "distance") own = std::abs(at(f, 0).value);
  }
  template <class T>
  void operator()(std::string_view, const T&) {}
};

template <class Kind>
double take_lengths(const System& system, const Action& action, const Kind& kind,
                    std::vector<double>& bodies) {
  FieldLengths fields{system, action, bodies};
  std::visit([&](const auto& k) { k.fields(k, fields); }, kind);
  return fields.own;
}

/// The length of each body from the tree alone: offsets and inertia.
std::vector<double> body_lengths(const System& system) {
  std::vector<double> lengths(system.bodies.size(), 0);
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    const Body& body = system.bodies[b];
    double& length = lengths[b];
    const int first = body.parent == 0 ? body.first_step + 1 : body.first_step;
    for (int s = first; s < body.first_step + body.step_count; ++s)
      length = std::max(length, system.parameters.placements[s].X.p.norm());
    for (int solid : body.solids) length = std::max(length, system.parameters.solid_places[solid].X.p.norm());
    const Inertial& inertial = system.parameters.inertials[b];
    if (inertial.mass > 0)
      length = std::max(length, inertial.centre.norm() + std::sqrt(inertial.tensor.trace() / inertial.mass));
  }
  return lengths;
}

}  // namespace

void find_groups(System& system) {
  const std::vector<int> velocity_body = velocity_bodies(system);
  JoinedSets sets(system.bodies.size());
  for (std::size_t b = 1; b < system.bodies.size(); ++b)
    if (system.bodies[b].parent != 0) sets.join(int(b), system.bodies[b].parent);
  for (const auto* actions : {&system.efforts, &system.constraints})
    for (const Action& action : *actions) {
      const std::vector<int> bodies = bodies_of(system, action, velocity_body);
      for (int b : bodies) sets.join(b, bodies[0]);
    }
  std::vector<int> number(system.bodies.size(), -1);
  system.groups = 0;
  for (std::size_t b = 1; b < system.bodies.size(); ++b) {
    int& group = number[sets.find(int(b))];
    if (group < 0) group = system.groups++;
    system.bodies[b].group = group;
  }
  system.groups = std::max(system.groups, 1);
  for (auto* actions : {&system.efforts, &system.constraints})
    for (Action& action : *actions) {
      const std::vector<int> bodies = bodies_of(system, action, velocity_body);
      if (!bodies.empty()) action.group = system.bodies[bodies[0]].group;
    }
  system.velocity_groups.clear();
  for (int b : velocity_body) system.velocity_groups.push_back(system.bodies[b].group);
}

void find_lengths(System& system) {
  std::vector<double> bodies = body_lengths(system), kept;
  for (std::size_t i = 0; i < system.efforts.size(); ++i)
    take_lengths(system, system.efforts[i], system.parameters.efforts[i].kind, bodies);
  for (std::size_t i = 0; i < system.constraints.size(); ++i)
    kept.push_back(
        take_lengths(system, system.constraints[i], system.parameters.constraints[i].kind, bodies));

  std::vector<double> groups(system.groups, 0);
  for (std::size_t b = 1; b < bodies.size(); ++b)
    groups[system.bodies[b].group] = std::max(groups[system.bodies[b].group], bodies[b]);
  for (std::size_t i = 0; i < kept.size(); ++i)
    groups[system.constraints[i].group] = std::max(groups[system.constraints[i].group], kept[i]);
  const auto or_group = [&](double length, int group) {
    return length > 0 ? length : groups[group] > 0 ? groups[group] : 1;
  };

  std::vector<double> carried = bodies;  // the largest of a body and its descendants
  for (std::size_t b = bodies.size(); --b > 0;)
    carried[system.bodies[b].parent] = std::max(carried[system.bodies[b].parent], carried[b]);
  const std::vector<int> velocity_body = velocity_bodies(system);
  system.velocity_scale.assign(system.nv, 1);
  for (const CoordinateInfo& info : system.coordinates)
    for (int i = info.v_index; i < info.v_index + info.v_size; ++i)
      if (!info.angle)
        system.velocity_scale[i] = or_group(carried[velocity_body[i]], system.velocity_groups[i]);

  system.row_scale.clear();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Action& action = system.constraints[i];
    double length = kept[i];
    for (int b : bodies_of(system, action, velocity_body)) length = std::max(length, bodies[b]);
    const int length_rows =
        std::visit([](const auto& kind) { return kind.length_rows; }, system.parameters.constraints[i].kind);
    for (int r = 0; r < action.row_count; ++r)
      system.row_scale.push_back(r < length_rows ? or_group(length, action.group) : 1);
  }
}

}  // namespace borelli
