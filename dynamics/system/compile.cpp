// compile(): converts the user's scene to the flat System that the engine runs on. It resolves every name and
// checks every number, once, so that later code needs no strings.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "dynamics/system/action_sites.hpp"
#include "dynamics/system/coordinate_layout.hpp"
#include "dynamics/system/coupled_switch.hpp"
#include "dynamics/system/groups.hpp"
#include "dynamics/system/solid_order.hpp"
#include "dynamics/system/switch_check.hpp"
#include "process/memory.hpp"

namespace borelli {

namespace {

class Compiler {
 public:
  Compiler(const Scene& scene, Welds welds) : scene_(scene), welds_(welds) {}

  Result<System> run() {
    system_.scene = scene_.name;
    system_.file = scene_.file;
    system_.settings = scene_.simulation;
    system_.parameters.gravity = scene_.gravity;
    if (!scene_.gravity.allFinite())
      return bad_use(scene_.place(0) + "gravity", "is not a finite vector; expected three numbers, m/s^2");
    if (auto fits = admit(); !fits) return tl::unexpected(fits.error());
    auto ordered = order_solids(scene_);
    if (!ordered) return tl::unexpected(ordered.error());
    solid_index_ = std::move(ordered->number);
    system_.bodies.emplace_back();  // the world
    system_.solid_bodies.assign(scene_.solids.size(), 0);
    system_.parameters.solid_places.resize(scene_.solids.size());
    for (const Solid& solid : scene_.solids) system_.solids.push_back(solid.name);
    for (int index : ordered->order)
      if (auto done = add_solid(index); !done) return tl::unexpected(done.error());
    lay_out_coordinates(system_);
    system_.initial.q = Eigen::Map<Eigen::VectorXd>(initial_q_.data(), system_.nq);
    system_.initial.v = Eigen::Map<Eigen::VectorXd>(initial_v_.data(), system_.nv);
    if (auto done = add_inertials(); !done) return tl::unexpected(done.error());
    if (auto done = check_mass_moved(); !done) return tl::unexpected(done.error());
    ActionSites actions(scene_, solid_index_, coordinates_, system_);
    if (auto done = actions.add_efforts(); !done) return tl::unexpected(done.error());
    if (auto done = actions.add_constraints(); !done) return tl::unexpected(done.error());
    if (auto done = check_markers(); !done) return tl::unexpected(done.error());
    measure_length(actions.farthest());
    system_.alike_trees = find_alike_trees(system_);
    return std::move(system_);
  }

 private:
  Result<void> admit() const {
    constexpr double size_each = 600;  // bytes of a solid's body, or of a coordinate with its names
    constexpr double few = 16e6;
    std::size_t switches = 0;
    for (const Solid& solid : scene_.solids) switches += solid.switches.size();
    const double bytes = size_each * static_cast<double>(scene_.solids.size() + switches) +
                         2. * sizeof(Constraint) * static_cast<double>(scene_.constraints.size()) +
                         2. * sizeof(Effort) * static_cast<double>(scene_.efforts.size());
    if (bytes < few) return {};
    return admit_memory(scene_.file.empty() ? scene_.name : scene_.file,
                        fmt::format("a system of {} solids and {} switches", scene_.solids.size(), switches),
                        bytes);
  }

  // ---- the tree ----

  Result<void> add_solid(int index) {
    const Solid& solid = scene_.solids[index];
    const int parent_solid = solid.parent == world_name ? -1 : solid_index_.at(solid.parent);
    const int parent_body = parent_solid < 0 ? 0 : system_.solid_bodies[parent_solid];
    Pose X = parent_solid < 0 ? Pose{} : system_.parameters.solid_places[parent_solid].X;
    const int first_step = int(system_.steps.size());
    for (std::size_t i = 0; i < solid.switches.size(); ++i)
      if (auto done = add_switch(solid, solid.switches[i], coordinate_name(solid, i), X); !done) return done;
    const int step_count = int(system_.steps.size()) - first_step;
    int body = parent_body;
    if (step_count > 0 || welds_ == Welds::kept) {
      body = int(system_.bodies.size());
      Body& added = system_.bodies.emplace_back();
      added.parent = parent_body;
      added.first_step = first_step;
      added.step_count = step_count;
      step_body_.resize(system_.steps.size(), body);
    }
    system_.bodies[body].solids.push_back(index);
    system_.solid_bodies[index] = body;
    system_.parameters.solid_places[index] = Placement(X);
    return {};
  }

  // ---- switches ----

  /// Adds a moving switch as a step behind the placement X, and resets X. A switch that does not move is
  /// merged into X.
  Result<void> add_switch(const Solid& solid, const Switch& one, const std::string& name, Pose& X) {
    const std::string where =
        scene_.where(solid) + (name.empty() ? "" : fmt::format(", coordinate '{}'", name));
    const auto checked = check_switch(one, where);
    if (!checked) return tl::unexpected(checked.error());
    const auto& [kind, kind_name, nq, nv, rotates, slides, q, v] = *checked;
    if (nv == 0) {
      move_through(kind, q.data(), X);
      return {};
    }
    KnownCoordinate known{
        .step = -1, .nq = nq, .value = nq == 1 ? q[0] : 0, .solid = solid.name, .ranges = one.ranges};
    if (nq == 4) known.turn = Eigen::Map<const Quaternion>(q.data());
    const bool locked = std::holds_alternative<Locked>(one.motion);
    if (!locked) known.step = int(system_.steps.size());
    if (const auto [first, is_new] = coordinates_.emplace(name, known); !is_new)
      return bad_use(where, fmt::format("solid '{}' has a coordinate of this name too; names must differ",
                                        first->second.solid));
    if (locked) {
      move_through(kind, q.data(), X);
      return {};
    }
    SwitchStep step{.nq = nq, .nv = nv, .rotates = rotates, .slides = slides};
    CoordinateInfo info{
        .name = name, .kind = kind_name, .solid = solid.name, .q_size = nq, .v_size = nv, .angle = rotates};
    if (const auto* driven = std::get_if<Driven>(&one.motion)) {
      Drive drive{.functions = driven->functions};
      if (nq == 4) drive.initial = Eigen::Map<const Quaternion>(q.data());
      system_.parameters.drives.push_back(drive);
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
      if (!one.ranges.empty()) system_.ranges.push_back({int(system_.coordinates.size()), one.ranges});
      system_.coordinates.push_back(info);
      initial_q_.insert(initial_q_.end(), q.begin(), q.end());
      initial_v_.insert(initial_v_.end(), v.begin(), v.end());
    }
    system_.steps.push_back(step);
    system_.parameters.placements.emplace_back(X);
    system_.parameters.kinds.push_back(kind);
    system_.parameters.armatures.push_back(one.armature);
    X = Pose{};
    return {};
  }

  // ---- inertia ----

  Result<void> add_inertials() {
    system_.parameters.inertials.resize(system_.bodies.size());
    for (std::size_t s = 0; s < scene_.solids.size(); ++s) {
      const std::string where = scene_.where(scene_.solids[s]);
      auto inertials = inertials_of(scene_.solids[s]);
      if (!inertials) {
        const Error& error = inertials.error();
        return tl::unexpected(
            Error{scene_.place(scene_.solids[s].line) + error.where, error.what, error.kind});
      }
      const int body = system_.solid_bodies[s];
      const Pose& X = system_.parameters.solid_places[s].X;
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
    std::vector<char> massive(system_.bodies.size(), 0);  // whether the body or one that it carries has
                                                          // inertia
    for (std::size_t b = system_.bodies.size() - 1; b > 0; --b) {
      if (system_.bodies[b].massive) massive[b] = 1;
      if (massive[b]) massive[system_.bodies[b].parent] = 1;
    }
    for (const CoordinateInfo& info : system_.coordinates) {
      const int step = coordinates_.at(info.name).step;
      if (massive[step_body_[step]] || system_.parameters.armatures[step] > 0) continue;
      return bad_use(
          fmt::format("{}, coordinate '{}'", scene_.where(scene_.solids[solid_index_.at(info.solid)]),
                      info.name),
          fmt::format("moves no mass: give '{}', or a solid that it carries, an inertial, or lock the "
                      "coordinate",
                      info.solid));
    }
    return {};
  }

  // ---- the rest ----

  Result<void> check_markers() const {
    std::set<std::string_view> names;
    for (const Marker& marker : scene_.markers) {
      const std::string where = fmt::format("{}marker '{}'", scene_.place(marker.line), marker.name);
      if (!names.insert(marker.name).second)
        return bad_use(where, "there is another of this name; names must differ");
      if (marker.at.solid != world_name && !solid_index_.contains(marker.at.solid))
        return bad_use(where, fmt::format("no solid is named '{}'", marker.at.solid));
      if (!marker.at.point.allFinite()) return bad_use(where, "its point is not finite");
    }
    return {};
  }

  /// The size of the scene: the largest distance in its data.
  void measure_length(double farthest) {
    double length = farthest;
    for (const Placement& placement : system_.parameters.placements)
      length = std::max(length, placement.X.p.norm());
    for (const Placement& place : system_.parameters.solid_places)
      length = std::max(length, place.X.p.norm());
    for (const Inertial& inertial : system_.parameters.inertials) {
      if (inertial.mass <= 0) continue;
      length = std::max(length, inertial.centre.norm() + std::sqrt(inertial.tensor.trace() / inertial.mass));
    }
    system_.length = length > 0 ? length : 1;
    find_groups(system_);
    find_lengths(system_);
  }

  const Scene& scene_;
  const Welds welds_;
  System system_;
  std::map<std::string, int> solid_index_;
  std::map<std::string, KnownCoordinate> coordinates_;
  std::vector<double> initial_q_, initial_v_;
  std::vector<int> step_body_;
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

int System::bilateral_rows() const {
  int count = rows;
  for (const Contact& contact : contacts) count -= contact.tangents ? 3 : 1;
  return count;
}

bool System::has_kinematic_rows() const {
  return std::find(kinematic_rows.begin(), kinematic_rows.end(), 1) != kinematic_rows.end();
}

std::string System::row_place(int row) const {
  return fmt::format("{}constraint '{}'", place_in(file, parameters.constraints[row_constraint[row]].line),
                     row_names[row]);
}

std::string System::tied_solids(int constraint) const {
  const Action& action = constraints[constraint];
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (int i = action.first_site; i < action.first_site + action.site_count; ++i) {
    if (sites[i].solid >= 0)
      add(solids[sites[i].solid]);
    else if (sites[i].body == 0)
      add(world_name);
  }
  for (int i = action.first_coordinate; i < action.first_coordinate + action.coordinate_count; ++i) {
    const int u = coordinate_sites[i].u;
    for (const auto* infos : {&coordinates, &driven})
      for (const CoordinateInfo& info : *infos)
        if (u >= 0 && info.v_index == (infos == &coordinates ? u : u - nv)) add(info.solid);
  }
  return fmt::format("'{}'", fmt::join(names, "' and '"));
}

namespace {

std::string component_name(const CoordinateInfo& info, int component) {
  return info.v_size == 1 ? info.name : fmt::format("{}.{}", info.name, "xyz"[component]);
}

}  // namespace

std::string System::velocity_name(int i) const {
  for (const CoordinateInfo& info : coordinates)
    if (i >= info.v_index && i < info.v_index + info.v_size) return component_name(info, i - info.v_index);
  return fmt::format("velocity {}", i);
}

std::vector<std::string> System::velocity_names() const {
  std::vector<std::string> names;
  for (const CoordinateInfo& info : coordinates)  // (in the order of their velocities)
    for (int i = 0; i < info.v_size; ++i) names.push_back(component_name(info, i));
  return names;
}

Result<System> compile(const Scene& scene, Welds welds) {
  const bool coupled = std::any_of(scene.solids.begin(), scene.solids.end(), [](const Solid& solid) {
    return std::any_of(solid.switches.begin(), solid.switches.end(),
                       [](const Switch& s) { return std::holds_alternative<Coupled>(s.motion); });
  });
  if (!coupled) return Compiler(scene, welds).run();
  const auto whole = without_coupled_switches(scene);
  return whole ? Compiler(*whole, welds).run() : tl::unexpected(whole.error());
}

}  // namespace borelli
