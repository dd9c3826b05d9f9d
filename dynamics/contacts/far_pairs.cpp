#include "dynamics/contacts/far_pairs.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/scene/convex.hpp"

namespace borelli {

using Eigen::Vector3d;

FarPairs::FarPairs(const System& system) {
  for (std::size_t i = 0; i < system.constraints.size(); ++i) {
    const Action& action = system.constraints[i];
    const Site* sites = system.sites.data() + action.first_site;
    const ConstraintKind& kind = system.parameters.constraints[i].kind;
    const auto add = [&](const auto& k, double half_a, double half_b) {
      const int a = ball(system, sites[0], k.a.point, half_a, half_a + k.radii.a),
                b = ball(system, sites[1], k.b.point, half_b, half_b + k.radii.b);
      pairs_.push_back({int(i), action.first_row, a, b, 1});
    };
    if (const auto* spheres = std::get_if<SphereOverSphere>(&kind)) add(*spheres, 0, 0);
    if (const auto* capsules = std::get_if<CapsuleOverCapsule>(&kind))
      add(*capsules, capsules->length_a / 2, capsules->length_b / 2);
    if (const auto* pair = std::get_if<ConvexOverConvex>(&kind)) {
      const auto around = [&](const Site& site, const Convex& convex) {
        return ball(system, site, convex.X_SF * convex.centre, convex.bound, convex.bound);
      };
      const int a = around(sites[0], *pair->convex_a), b = around(sites[1], *pair->convex_b);
      pairs_.push_back({int(i), action.first_row, a, b, pair->rows() / pair->contact_rows});
    }
  }
}

int FarPairs::ball(const System& system, const Site& site, const Vector3d& centre, double half,
                   double radius) {
  const Vector3d p = site.solid < 0 ? centre : system.parameters.solid_places[site.solid] * centre;
  const auto same = [&](const Ball& b) {
    return b.body == site.body && b.centre == p && b.half == half && b.radius == radius;
  };
  const auto found = std::find_if(balls_.begin(), balls_.end(), same);
  if (found != balls_.end()) return int(found - balls_.begin());
  Ball& added = balls_.emplace_back();
  added.body = site.body;
  added.centre = p;
  added.half = half;
  added.radius = radius;
  return int(balls_.size()) - 1;
}

void FarPairs::mark(const Kinematics& kinematics, double time, double distance, ConstraintRows& rows) {
  for (Ball& ball : balls_) {
    const BodyMotion& body = kinematics.bodies[ball.body];
    const Vector3d arm = body.X.R * ball.centre;
    ball.p = body.X.p + arm;
    ball.v = body.v + body.w.cross(ball.p - body.g);
    ball.turns = ball.half * body.w.norm();
  }
  for (const Pair& pair : pairs_) {
    const Ball &a = balls_[pair.a], &b = balls_[pair.b];
    const double gap = (a.p - b.p).norm() - a.radius - b.radius;
    // (Most pairs are far apart: test the distance alone before the speeds.)
    const bool far = gap > distance && gap > distance + time * ((a.v - b.v).norm() + a.turns + b.turns);
    rows.far[pair.constraint] = far;
    if (!far) continue;
    for (int contact = 0; contact < pair.contacts; ++contact) {
      rows.h[pair.row + 3 * contact] = gap;
      rows.speed[pair.row + 3 * contact] = 0;
    }
  }
}

}  // namespace borelli
