#include "dynamics/momentum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "dynamics/jacobian.hpp"
#include "dynamics/processor.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Solids that hang together: trees that efforts or constraints join, and whether something joins them to the
/// world.
struct Group {
  std::vector<int> roots;  ///< bodies whose parent is the world
  std::vector<int> bodies;
  bool tied = false;
};

/// How a root body's first switches let it move.
struct Leading {
  Matrix3d translations = Matrix3d::Zero();  ///< projector on the free directions
  int translation_count = 0;
  int turns = 0;  ///< of the switch after them: 0, 1 (about `axis`) or 3
  Vector3d axis = Vector3d::Zero();
  Vector3d point = Vector3d::Zero();  ///< where it turns, if it does not translate
};

class Structure {
 public:
  Structure(const System& system, const Parameters& parameters) : system_(system), parameters_(parameters) {
    const int count = int(system.bodies.size());
    leader_.resize(count);
    std::iota(leader_.begin(), leader_.end(), 0);
    for (int b = 1; b < count; ++b)
      if (system.bodies[b].parent != 0) leader_[b] = find(system.bodies[b].parent);
    tied_.assign(count, false);
    for (std::size_t i = 0; i < system.efforts.size(); ++i)
      join(system.efforts[i], parameters.efforts[i].kind);
    for (std::size_t i = 0; i < system.constraints.size(); ++i)
      join(system.constraints[i], parameters.constraints[i].kind);
  }

  std::vector<Group> groups() {
    std::vector<Group> groups;
    for (int b = 1; b < int(leader_.size()); ++b) {
      auto group = std::find_if(groups.begin(), groups.end(),
                                [&](const Group& g) { return find(g.bodies[0]) == find(b); });
      if (group == groups.end()) group = groups.insert(groups.end(), Group{});
      group->bodies.push_back(b);
      if (system_.bodies[b].parent == 0) group->roots.push_back(b);
      group->tied = group->tied || tied_[b];
    }
    return groups;
  }

  Leading leading(int root) const {
    Leading out;
    const Body& body = system_.bodies[root];
    Pose X;  // while only translations at zero have been passed; what they add does not turn
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const Step& step = system_.steps[s];
      // (an armature leans on the world)
      if (step.drive >= 0 || acted_on_.count(step.u) || parameters_.armatures[s] > 0) return out;
      X = X * parameters_.placements[s].X;
      const SwitchKind& kind = parameters_.kinds[s];
      if (const auto* translation = std::get_if<Translation>(&kind)) {
        add_direction(X.R * translation->axis, out.translations);
        ++out.translation_count;
        continue;
      }
      if (const auto* rotation = std::get_if<Rotation>(&kind)) {
        out.turns = 1;
        out.axis = X.R * rotation->axis;
      } else if (std::holds_alternative<Ball>(kind)) {
        out.turns = 3;
      }
      out.point = X.p;
      return out;
    }
    return out;
  }

 private:
  int find(int b) { return leader_[b] == b ? b : leader_[b] = find(leader_[b]); }

  template <class Kind>
  void join(const Action& action, const Kind& kind) {
    int first = -1;
    bool tied = std::visit([]<class K>(const K&) { return LeansOnWorld<K>; }, kind);
    for (int i = action.first_site; i < action.first_site + action.site_count; ++i)
      if (system_.sites[i].body <= 0) tied = true;  // the world, or no reaction given
    for (int i = action.first_site; i < action.first_site + action.site_count; ++i) {
      const int body = system_.sites[i].body;
      if (body <= 0) continue;
      if (first >= 0) leader_[find(body)] = find(first);
      first = body;
      tied_[body] = tied_[body] || tied;
    }
    for (int i = action.first_coordinate; i < action.first_coordinate + action.coordinate_count; ++i)
      acted_on_.insert(system_.coordinate_sites[i].u);
  }

  static void add_direction(const Vector3d& axis, Matrix3d& projector) {
    const Vector3d rest = axis - projector * axis;
    if (rest.norm() < 1e-9) return;
    const Vector3d unit = rest.normalized();
    projector += unit * unit.transpose();
  }

  const System& system_;
  const Parameters& parameters_;
  std::vector<int> leader_;
  std::vector<char> tied_;
  std::set<int> acted_on_;  ///< velocities that an effort or constraint names
};

int rank(const Matrix3d& projector) { return int(std::lround(projector.trace())); }

Matrix3d onto(const Vector3d& axis) { return axis * axis.transpose() / axis.squaredNorm(); }

/// A lone tree's angular momentum, by how its root turns; false: none is conserved.
bool find_angular(const Leading& leading, const Vector3d& gravity, ConservedMomentum& out) {
  const bool weightless = gravity.norm() == 0;
  if (leading.turns == 0) return false;
  if (leading.turns == 3) {
    if (rank(leading.translations) == 3) {
      out.about = ConservedMomentum::About::gravity_centre;
      return true;
    }
    if (leading.translation_count > 0) return false;
    out.about = ConservedMomentum::About::fixed_point;
    out.point = leading.point;
    if (!weightless) out.directions = onto(gravity);
    return true;
  }
  const Vector3d& axis = leading.axis;
  const Matrix3d across = leading.translations * (Matrix3d::Identity() - onto(axis));
  const bool along_only = across.norm() < 1e-9;
  out.directions = onto(axis);
  if (along_only) {  // the axis stays in the world
    if (!weightless && gravity.cross(axis).norm() > 1e-12 * gravity.norm()) return false;
    out.about = ConservedMomentum::About::fixed_point;
    out.point = leading.point;
    return true;
  }
  // free in the plane across the axis
  if (rank(leading.translations) < 2 || across.norm() < std::sqrt(2.0) - 1e-9) return false;
  out.about = ConservedMomentum::About::gravity_centre;
  return true;
}

}  // namespace

std::vector<ConservedMomentum> conserved_momenta(const System& system, const Parameters& parameters) {
  std::vector<ConservedMomentum> out;
  Structure structure(system, parameters);
  for (const Group& group : structure.groups()) {
    if (group.tied || group.roots.empty()) continue;
    const std::string of = fmt::format("of '{}'", system.solids[system.bodies[group.roots[0]].solids[0]]);
    Leading leading = structure.leading(group.roots[0]);
    if (group.roots.size() > 1) {  // several trees: only if each floats freely
      const bool floating = std::all_of(group.roots.begin(), group.roots.end(), [&](int root) {
        const Leading one = structure.leading(root);
        return rank(one.translations) == 3 && one.turns == 3;
      });
      if (!floating) continue;
    }
    if (leading.translation_count > 0)
      out.push_back(
          {.name = "linear momentum " + of, .bodies = group.bodies, .directions = leading.translations});
    ConservedMomentum angular{.name = {}, .bodies = group.bodies};
    if (!find_angular(leading, parameters.gravity, angular)) continue;
    angular.name =
        fmt::format("angular momentum {} about {}", of,
                    angular.about == ConservedMomentum::About::gravity_centre ? "its gravity centre"
                    : leading.turns == 1                                      ? "its axis"
                                                                              : "its fixed point");
    out.push_back(angular);
  }
  return out;
}

BORELLI_INLINED_FOR_PROCESSOR
MomentumValue momentum_value(const ConservedMomentum& momentum, const Parameters& parameters,
                             const Kinematics& kinematics) {
  double mass = 0;
  Vector3d first = Vector3d::Zero(), linear = Vector3d::Zero();
  if (momentum.about != ConservedMomentum::About::fixed_point)
    for (int b : momentum.bodies) {
      const double m = parameters.inertials[b].mass;
      mass += m;
      first += m * kinematics.bodies[b].g;
      linear += m * kinematics.bodies[b].v;
    }
  MomentumValue out;
  if (momentum.about == ConservedMomentum::About::nothing) {
    out.value = momentum.directions * (linear - mass * kinematics.t * parameters.gravity);
    for (int b : momentum.bodies) out.scale += parameters.inertials[b].mass * kinematics.bodies[b].v.norm();
    out.rounding = 1e-12 * out.scale;
    return out;
  }
  const bool centre = mass > 0;
  const Vector3d point = centre ? Vector3d(first / mass) : momentum.point;
  const Vector3d drift = centre ? Vector3d(linear / mass) : Vector3d(Vector3d::Zero());
  Vector3d angular = Vector3d::Zero();
  for (int b : momentum.bodies) {
    const BodyMotion& body = kinematics.bodies[b];
    const Inertial& inertial = parameters.inertials[b];
    if (inertial.mass <= 0) continue;
    const Vector3d arm = body.g - point, orbital = inertial.mass * arm.cross(body.v - drift),
                   own = spin(inertial, body);
    angular += orbital + own;
    const double reach =  // the longest of three, squared
        std::max({body.g.squaredNorm(), arm.squaredNorm(), inertial.centre.squaredNorm()});
    const double turning = own.norm();
    out.rounding += 1e-12 * (inertial.mass * std::sqrt(reach * body.v.squaredNorm()) + turning);
    out.scale += orbital.norm() + turning;
  }
  out.value = momentum.directions * angular;
  return out;
}

}  // namespace borelli
