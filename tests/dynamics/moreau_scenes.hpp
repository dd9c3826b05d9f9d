// Balls that Moreau's time stepping lets fall and meet.
#pragma once

#include "scenes.hpp"

namespace borelli::test::moreau_test {

inline Solid free_ball(const std::string& name, const Vector3d& at, double radius, double mass) {
  Solid out;
  out.name = name;
  out.parent = "world";
  out.switches = free_switches(name);
  for (int i = 0; i < 3; ++i) out.switches[i].q = {at[i]};
  const double I = 0.4 * mass * radius * radius;
  out.inertials = {inertial(mass, {0, 0, 0}, {I, I, I})};
  return out;
}

inline Constraint over_floor(const std::string& solid, double radius, double restitution, double friction) {
  SphereOverPlane kind;
  kind.sphere = {solid, {0, 0, 0}};
  kind.radius = radius;
  kind.plane.on = {"world", {0, 0, 0}};
  kind.surface.restitution = restitution;
  kind.surface.friction = friction;
  return {solid + " on floor", kind};
}

inline Constraint between(const std::string& a, const std::string& b, double radius, double restitution,
                          double friction) {
  SphereOverSphere kind;
  kind.a = {a, {0, 0, 0}};
  kind.b = {b, {0, 0, 0}};
  kind.radii = {radius, radius};
  kind.surface.restitution = restitution;
  kind.surface.friction = friction;
  return {a + " on " + b, kind};
}

}  // namespace borelli::test::moreau_test
