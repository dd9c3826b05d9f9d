#include "dynamics/equations/momentum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "dynamics/numbers/processor.hpp"
#include "dynamics/system/joined_sets.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Trees joined by efforts or constraints, and whether something joins them to the world.
struct Group {
  std::vector<int> roots;  ///< bodies whose parent is the world
  std::vector<int> bodies;
  bool tied = false;
};

/// Freedom of a root body by its first switches.
struct Leading {
  Matrix3d translations = Matrix3d::Zero();  ///< projector on the free directions
  int translation_count = 0;
  int turns = 0;  ///< rotations of the next switch: 0, 1 (about `axis`) or 3
  Vector3d axis = Vector3d::Zero();
  Vector3d point = Vector3d::Zero();  ///< centre of rotation, if it does not translate
};

class Structure {
 public:
  Structure(const System& system, const Parameters& parameters)
      : system_(system), parameters_(parameters), sets_(system.bodies.size()) {
    const int count = int(system.bodies.size());
    for (int b = 1; b < count; ++b)
      if (system.bodies[b].parent != 0) sets_.join(b, system.bodies[b].parent);
    tied_.assign(count, false);
    for (std::size_t i = 0; i < system.efforts.size(); ++i)
      join(system.efforts[i], parameters.efforts[i].kind);
    for (std::size_t i = 0; i < system.constraints.size(); ++i)
      join(system.constraints[i], parameters.constraints[i].kind);
  }

  std::vector<Group> groups() {
    std::vector<Group> groups;
    std::vector<int> number(system_.bodies.size(), -1);  // group number per set representative
    for (int b = 1; b < int(system_.bodies.size()); ++b) {
      int& of = number[sets_.find(b)];
      if (of < 0) {
        of = int(groups.size());
        groups.emplace_back();
      }
      Group& group = groups[of];
      group.bodies.push_back(b);
      if (system_.bodies[b].parent == 0) group.roots.push_back(b);
      group.tied = group.tied || tied_[b];
    }
    return groups;
  }

  Leading leading(int root) const {
    Leading out;
    const Body& body = system_.bodies[root];
    Pose X;  // pose with all translations at zero; they do not rotate it
    for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
      const SwitchStep& step = system_.steps[s];
      // (an armature reacts on the world)
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
  template <class Kind>
  void join(const Action& action, const Kind& kind) {
    int first = -1;
    bool tied = std::visit([]<class K>(const K&) { return LeansOnWorld<K>; }, kind);
    for (int i = action.first_site; i < action.first_site + action.site_count; ++i)
      if (system_.sites[i].body <= 0) tied = true;  // the world, or no reaction body
    for (int i = action.first_site; i < action.first_site + action.site_count; ++i) {
      const int body = system_.sites[i].body;
      if (body <= 0) continue;
      if (first >= 0) sets_.join(body, first);
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
  JoinedSets sets_;
  std::vector<char> tied_;
  std::set<int> acted_on_;  ///< velocities on which an effort or constraint acts directly
};

/// A vector computed number by number. Scalar loads of scalar stores do not stall, unlike pair loads of
/// numbers just written.
struct Numbers {
  double x = 0, y = 0, z = 0;

  Numbers() = default;
  Numbers(double x, double y, double z) : x(x), y(y), z(z) {}
  Numbers(const Vector3d& a) : Numbers(a.x(), a.y(), a.z()) {}
  operator Vector3d() const { return {x, y, z}; }

  double norm() const { return std::sqrt(squared_norm()); }
  double squared_norm() const { return x * x + y * y + z * z; }
  friend Numbers operator+(const Numbers& a, const Numbers& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Numbers operator-(const Numbers& a, const Numbers& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Numbers operator*(double f, const Numbers& a) { return {f * a.x, f * a.y, f * a.z}; }
  friend Numbers cross(const Numbers& a, const Numbers& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
};

/// Sums over several bodies.
struct Sums {
  double mass = 0;
  Numbers first, linear;  ///< mass times gravity centre, and times its velocity

  void add(const Inertial& inertial, const BodyMotion& body) {
    mass += inertial.mass;
    first = first + inertial.mass * Numbers(body.g);
    linear = linear + inertial.mass * Numbers(body.v);
  }
};

int rank(const Matrix3d& projector) { return int(std::lround(projector.trace())); }

Matrix3d onto(const Vector3d& axis) { return axis * axis.transpose() / axis.squaredNorm(); }

/// Conserved angular momentum of a group, from the freedom of its root. Returns false if none is conserved.
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
  if (along_only) {  // the axis is fixed in the world
    if (!weightless && gravity.cross(axis).norm() > 1e-12 * gravity.norm()) return false;
    out.about = ConservedMomentum::About::fixed_point;
    out.point = leading.point;
    return true;
  }
  // The root must translate freely in the plane perpendicular to the axis.
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
    if (group.roots.size() > 1) {  // several trees: conserved only if each floats freely
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
const std::vector<Vector3d>& find_spins(const Parameters& parameters, Kinematics& k) {
  if (!k.spins.empty()) return k.spins;
  const std::size_t count = k.bodies.size();
  k.spins.resize(count);
  const Inertial* const inertials = parameters.inertials.data();
  const BodyMotion* const bodies = k.bodies.data();
  Vector3d* const spins = k.spins.data();
  spins[0].setZero();
  for (std::size_t b = 1; b < count; ++b) {
    if (inertials[b].mass > 0) {
      const Eigen::Matrix3d& R = bodies[b].X.R;  // the tensor is in the body's axes
      spins[b] = R * Vector3d(inertials[b].tensor * Vector3d(R.transpose() * bodies[b].w));
    } else {
      spins[b].setZero();
    }
  }
  return k.spins;
}

BORELLI_INLINED_FOR_PROCESSOR
Momenta momenta(const System& system, const Parameters& parameters, Kinematics& k) {
  const Vector3d* const spins = find_spins(parameters, k).data();
  const std::size_t count = system.bodies.size();
  const Inertial* const inertials = parameters.inertials.data();
  const BodyMotion* const bodies = k.bodies.data();
  Sums all;
  for (std::size_t b = 1; b < count; ++b) all.add(inertials[b], bodies[b]);
  const double inverse = all.mass > 0 ? 1 / all.mass : 0;
  const Numbers centre = inverse * all.first, velocity = inverse * all.linear;
  Numbers angular;
  for (std::size_t b = 1; b < count; ++b) {
    if (!system.bodies[b].massive) continue;
    const Numbers arm = Numbers(bodies[b].g) - centre, speed = Numbers(bodies[b].v) - velocity;
    angular = angular + (inertials[b].mass * cross(arm, speed) + spins[b]);
  }
  return {.mass = all.mass, .centre = centre, .velocity = velocity, .linear = all.linear, .angular = angular};
}

BORELLI_INLINED_FOR_PROCESSOR
MomentumValue momentum_value(const ConservedMomentum& momentum, const Parameters& parameters,
                             Kinematics& kinematics) {
  const Inertial* const inertials = parameters.inertials.data();
  const BodyMotion* const bodies = kinematics.bodies.data();
  Sums all;
  if (momentum.about != ConservedMomentum::About::fixed_point)
    for (int b : momentum.bodies) all.add(inertials[b], bodies[b]);
  double scale = 0, rounding = 0;
  if (momentum.about == ConservedMomentum::About::nothing) {
    for (int b : momentum.bodies) scale += inertials[b].mass * Numbers(bodies[b].v).norm();
    const Vector3d without_weight = all.linear - all.mass * kinematics.t * Numbers(parameters.gravity);
    return {.value = momentum.directions * without_weight, .scale = scale, .rounding = 1e-12 * scale};
  }
  const bool centre = all.mass > 0;
  const Numbers point = centre ? 1 / all.mass * all.first : Numbers(momentum.point);
  const Numbers drift = centre ? 1 / all.mass * all.linear : Numbers();
  const Vector3d* const spins = find_spins(parameters, kinematics).data();
  Numbers angular;
  for (int b : momentum.bodies) {
    const double mass = inertials[b].mass;
    if (mass <= 0) continue;
    const Numbers g = bodies[b].g, v = bodies[b].v, arm = g - point, own = spins[b],
                  orbital = mass * cross(arm, v - drift);
    angular = angular + (orbital + own);
    const double reach =  // squared, the longest of three distances
        std::max({g.squared_norm(), arm.squared_norm(), inertials[b].centre.squaredNorm()});
    const double turning = own.norm();
    rounding += 1e-12 * (mass * std::sqrt(reach * v.squared_norm()) + turning);
    scale += orbital.norm() + turning;
  }
  return {.value = momentum.directions * Vector3d(angular), .scale = scale, .rounding = rounding};
}

}  // namespace borelli
