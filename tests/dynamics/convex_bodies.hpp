// Free bodies of convex shapes, and contacts between them.
#pragma once

#include "scenes.hpp"

namespace borelli::test::convex_contact_test {

inline Shape at_origin(const Form& form) { return {form, Vector3d::Zero(), Eigen::Quaterniond::Identity()}; }

inline Solid body_of(const std::string& name, double mass, const Form& form, const Pose& X) {
  Solid out;
  out.name = name;
  out.parent = "world";
  out.switches = free_switches(name);
  for (int i = 0; i < 3; ++i) out.switches[std::size_t(i)].q = {X.p[i]};
  const Quaternion q = quaternion(X.R);
  out.switches[3].q = {q[0], q[1], q[2], q[3]};
  out.inertials = {need(inertial_of_mass(at_origin(form), mass))};
  return out;
}

inline Constraint meets(const std::string& a, const Form& fa, const std::string& b, const Form& fb,
                        double friction, double restitution = 0) {
  return {a + " on " + b,
          ConvexOverConvex{{a}, {b}, at_origin(fa), at_origin(fb), {restitution, friction}, {}, {}}};
}

inline Constraint on_floor(const std::string& a, const Form& form, double friction) {
  return {a + " on floor", ConvexOverPlane{{a}, at_origin(form), {}, {0, friction}, {}}};
}

}  // namespace borelli::test::convex_contact_test
