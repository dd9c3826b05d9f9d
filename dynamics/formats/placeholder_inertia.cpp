#include "dynamics/formats/placeholder_inertia.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "dynamics/system/solid_order.hpp"
#include "dynamics/system/switch_check.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

bool is_free(const Switch& one) {
  return !std::holds_alternative<Fixed>(one.kind) && std::holds_alternative<Free>(one.motion);
}

bool moves(const Switch& one) {
  return !std::holds_alternative<Fixed>(one.kind) && !std::holds_alternative<Locked>(one.motion);
}

bool possible(const Inertial& inertial) {
  return bool(check_physical(inertial, "", Extent::may_be_bar_or_point));
}

// Moves the frame X through a switch that stays at its initial value.
Result<void> move_on(const Switch& one, const std::string& where, Pose& X) {
  const auto checked = check_switch(one, where);
  if (!checked) return tl::unexpected(checked.error());
  move_through(checked->kind, checked->q.data(), X);
  return {};
}

Inertial ball_of_water(double mass, const Eigen::Vector3d& centre) {
  constexpr double density = 1000;  // kg/m^3
  const double radius = std::cbrt(3 * mass / (4 * std::numbers::pi * density));
  return {mass, centre, 0.4 * mass * radius * radius * Eigen::Matrix3d::Identity()};
}

class Settling {
 public:
  Settling(Scene& scene, double minimum_mass) : scene_(scene), minimum_mass_(minimum_mass) {}

  Result<SettledInertias> run() {
    auto ordered = order_solids(scene_);
    if (!ordered) return tl::unexpected(ordered.error());
    number_ = std::move(ordered->number);
    order_ = std::move(ordered->order);
    if (auto done = find_bodies(); !done) return tl::unexpected(done.error());
    if (auto done = settle(); !done) return tl::unexpected(done.error());
    lock_massless();
    return std::move(notes_);
  }

 private:
  int parent_of(int solid) const {
    const std::string& name = scene_.solids[solid].parent;
    return name == world_name ? -1 : number_.at(name);
  }

  Result<void> find_bodies() {
    top_.assign(scene_.solids.size(), -1);
    X_.resize(scene_.solids.size());
    for (const int s : order_) {
      const Solid& solid = scene_.solids[s];
      const int parent = parent_of(s);
      if (std::any_of(solid.switches.begin(), solid.switches.end(), moves)) {
        top_[s] = s;  // (its pose in the body that carries it does not matter)
        continue;
      }
      top_[s] = parent < 0 ? -1 : top_[parent];
      X_[s] = parent < 0 ? Pose{} : X_[parent];
      for (const Switch& one : solid.switches)
        if (auto done = move_on(one, scene_.where(solid), X_[s]); !done) return done;
    }
    return {};
  }

  Result<void> settle() {
    std::vector<Inertial> sums(scene_.solids.size());
    std::vector<std::vector<std::string>> impossible(scene_.solids.size());  // names, by the top solid of the
                                                                             // body
    std::vector<std::string> dropped;
    for (const int s : order_) {
      Solid& solid = scene_.solids[s];
      const bool fine = std::all_of(solid.inertials.begin(), solid.inertials.end(), possible);
      if (top_[s] < 0) {
        if (!fine) solid.inertials.clear(), dropped.push_back(solid.name);
        continue;
      }
      for (const Inertial& one : solid.inertials) sums[top_[s]] += one.expressed_in(X_[s].R, X_[s].p);
      if (!fine) impossible[top_[s]].push_back(solid.name);
    }
    if (!dropped.empty())
      notes_.other.push_back(
          fmt::format("impossible inertias of links fixed to the world: {}", name_list(std::move(dropped))));
    std::vector<std::string> made_heavier, emptied;
    std::vector<char> is_one(scene_.solids.size(), 0);
    for (const int top : order_) {
      if (top_[top] != top) continue;
      if (sums[top].mass < minimum_mass_) {
        sums[top] = ball_of_water(minimum_mass_, sums[top].centre);
        made_heavier.push_back(scene_.solids[top].name);
      } else if (impossible[top].empty()) {
        continue;
      } else if (sums[top].mass == 0) {
        emptied.push_back(scene_.solids[top].name);
      } else if (const auto fine = check_physical(sums[top], "", Extent::may_be_bar_or_point); !fine) {
        return failure(impossible[top].front(),
                       fmt::format("{}; correct it, or replace it by a small ball: give --minimum-mass more "
                                   "than the {:.3g} kg that move with '{}'",
                                   fine.error().what, sums[top].mass, scene_.solids[top].name));
      } else {
        notes_.other.push_back(fmt::format("impossible inertias, added to '{}', with which they move: {}",
                                           scene_.solids[top].name, name_list(impossible[top])));
      }
      is_one[top] = 1;
    }
    for (const int s : order_)
      if (top_[s] >= 0 && is_one[top_[s]]) {
        scene_.solids[s].inertials.clear();
        if (top_[s] == s && sums[s].mass > 0) scene_.solids[s].inertials = {sums[s]};
      }
    if (!made_heavier.empty())
      notes_.motion.push_back(
          fmt::format("links lighter than {} kg, each replaced by a ball of water of that mass: {}",
                      minimum_mass_, name_list(std::move(made_heavier))));
    if (!emptied.empty())
      notes_.motion.push_back(
          fmt::format("moments of inertia without mass, ignored: {}", name_list(std::move(emptied))));
    return {};
  }

  void lock_massless() {
    std::vector<char> moves_mass(scene_.solids.size(), 0);
    for (auto s = order_.rbegin(); s != order_.rend(); ++s) {
      const Solid& solid = scene_.solids[*s];
      const bool turns_something = std::any_of(solid.switches.begin(), solid.switches.end(),
                                               [](const Switch& one) { return one.armature > 0; });
      const bool weighs =
          std::any_of(solid.shapes.begin(), solid.shapes.end(), [](const ShapeElement& shape) {
            return shape.mass.value_or(0) > 0 || shape.density.value_or(0) > 0;
          });
      if (!solid.inertials.empty() || turns_something || weighs) moves_mass[*s] = 1;
      if (const int parent = parent_of(*s); moves_mass[*s] && parent >= 0) moves_mass[parent] = 1;
    }
    std::set<std::string> massless;
    for (const int s : order_)
      for (std::size_t i = 0; i < scene_.solids[s].switches.size(); ++i)
        if (is_free(scene_.solids[s].switches[i]) && !moves_mass[s])
          massless.insert(coordinate_name(scene_.solids[s], i));
    // the second coordinate of a coupling moves what the first one moves
    for (bool again = true; again;) {
      again = false;
      for (const Constraint& constraint : scene_.constraints)
        if (const auto* tie = std::get_if<CoordinateCoupling>(&constraint.kind);
            tie && tie->coordinates.size() == 2 && !massless.contains(tie->coordinates[0].coordinate))
          again = massless.erase(tie->coordinates[1].coordinate) > 0 || again;
    }
    if (massless.empty()) return;
    std::vector<std::string> names;
    for (Solid& solid : scene_.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i)
        if (const std::string name = coordinate_name(solid, i); massless.contains(name)) {
          solid.switches[i].motion = Locked{};
          names.push_back(name);
        }
    std::erase_if(scene_.constraints, [&](const Constraint& constraint) {
      const auto* tie = std::get_if<CoordinateCoupling>(&constraint.kind);
      return tie && massless.contains(tie->coordinates[0].coordinate);
    });
    notes_.motion.push_back(
        fmt::format("coordinates that move no mass, locked (--minimum-mass gives them mass): {}",
                    name_list(std::move(names))));
  }

  Scene& scene_;
  const double minimum_mass_;
  SettledInertias notes_;
  std::map<std::string, int> number_;
  std::vector<int> order_;  // parents before their children
  std::vector<int> top_;    // per solid: the top solid of its body, which moves against its parent; -1: the
                            // world
  std::vector<Pose> X_;     // per solid: its pose in the frame of the top solid
};

}  // namespace

Result<void> lock_coordinates(Scene& scene, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    bool found = false;
    std::vector<std::string> known;
    for (Solid& solid : scene.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i) {
        Switch& one = solid.switches[i];
        const std::string own = coordinate_name(solid, i);
        if (!is_free(one) && !std::holds_alternative<Locked>(one.motion)) continue;
        if (own.empty()) continue;
        known.push_back(own);
        if (own != name && !own.starts_with(name + ".")) continue;
        one.motion = Locked{};
        one.v.clear();
        found = true;
      }
    if (!found)
      return bad_use("--lock " + name,
                     known.empty() ? "the scene has no free coordinate"
                                   : fmt::format("there is no free coordinate of this name; choose from: {}",
                                                 name_list(std::move(known))));
  }
  return {};
}

Result<SettledInertias> settle_inertias(Scene& scene, double minimum_mass) {
  return Settling(scene, minimum_mass).run();
}

}  // namespace borelli
