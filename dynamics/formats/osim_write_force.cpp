#include "dynamics/formats/osim_write_force.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <set>

#include "dynamics/formats/osim_function.hpp"
#include "dynamics/formats/osim_write_function.hpp"
#include "dynamics/numbers/rotation_between.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// q - bound, as an expression.
std::string minus_text(const std::string& variable, double bound) {
  if (bound == 0) return variable;
  return variable + (bound < 0 ? "+" : "-") + exact_text(std::abs(bound));
}

class OsimForceWriter {
 public:
  OsimForceWriter(const Scene& scene, const OsimNames& names, XmlNode& objects)
      : names_(names), objects_(objects) {
    for (const Solid& solid : scene.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i)
        if (solid.switches[i].ranges.size() == 1)
          ranges_[coordinate_name(solid, i)] = solid.switches[i].ranges[0];
  }

  /// What is lost; empty: nothing.
  std::string write(const std::string& name, const EffortKind& kind) {
    name_ = name;
    return std::visit([&](const auto& effort) { return add(effort); }, kind);
  }

 private:
  XmlNode& object(const char* kind) {
    XmlNode& node = objects_.add(kind).set("name", OsimNames::make(name_, taken_));
    node.add("appliesForce", "true");
    return node;
  }

  template <class Other>
  std::string add(const Other&) {
    return fmt::format("efforts of kind {} are not written; OpenSim has none", Other::kind);
  }

  std::string add(const PointSpring& spring) {
    if (spring.a.solid == spring.b.solid) return "springs within one solid are not written; they do nothing";
    const bool damped = spring.damping != 0;
    XmlNode& node = object(damped ? "ExpressionBasedPointToPointForce" : "PointToPointSpring");
    node.add(damped ? "body1" : "socket_body1", names_.path(spring.a.solid));
    node.add(damped ? "body2" : "socket_body2", names_.path(spring.b.solid));
    node.add("point1", osim_vector_text(names_.point(spring.a)));
    node.add("point2", osim_vector_text(names_.point(spring.b)));
    if (damped) {
      node.add("expression", fmt::format("{}*({})+{}*ddot", exact_text(spring.stiffness),
                                         minus_text("d", spring.rest_length), exact_text(spring.damping)));
    } else {
      node.add("stiffness", exact_text(spring.stiffness));
      node.add("rest_length", exact_text(spring.rest_length));
    }
    return "";
  }

  std::string add(const CoordinateSpring& spring) {
    XmlNode& node = object("SpringGeneralizedForce");
    node.add("coordinate", names_.coordinate(spring.on.coordinate));
    node.add("stiffness", exact_text(spring.stiffness));
    node.add("rest_length", exact_text(spring.rest));
    node.add("viscosity", exact_text(spring.damping));
    return "";
  }

  std::string add(const PdController& controller) {
    if (!names_.is_scalar(controller.on.coordinate)) return "controllers of balls are not written";
    if (!is_constant(controller.target[0])) return "controllers with moving targets are not written";
    return add(CoordinateSpring{
        {controller.on.coordinate}, controller.kp, controller.kd, at(controller.target[0], 0).value});
  }

  // Beyond each bound by x: stiffness x max(0, 1 + dissipation dx/dt).
  std::string add(const LimitSpring& spring) {
    if (!names_.is_scalar(spring.on.coordinate)) return "springs at limits of balls are not written";
    const Range range = spring.range.empty() ? ranges_.at(spring.on.coordinate) : spring.range[0];
    const std::string k = exact_text(spring.stiffness), c = exact_text(spring.dissipation);
    XmlNode& node = object("ExpressionBasedCoordinateForce");
    node.add("coordinate", names_.coordinate(spring.on.coordinate));
    node.add("expression", fmt::format("-{}*max(0,{})*max(0,1+{}*qdot)+{}*max(0,-({}))*max(0,1-{}*qdot)", k,
                                       minus_text("q", range.upper), c, k, minus_text("q", range.lower), c));
    return "";
  }

  std::string add(const Force& force) {
    const bool in_solid = force.axes == Axes::solid && force.at.solid != world_name;
    if (const std::string bad = osim_function_complaint(force.factor); !bad.empty())
      return "forces and torques that " + bad + ", are not written";
    if (in_solid && force.reaction && force.reaction->solid != world_name)
      return "forces and torques with a reaction in the axes of another solid are not written";
    if (force.at.solid != world_name) prescribe(force.at, force.force, in_solid, force.factor, "force");
    if (force.reaction && force.reaction->solid != world_name)
      prescribe(*force.reaction, -force.force, false, force.factor, "force");
    return "";
  }

  std::string add(const Torque& torque) {
    const bool in_solid = torque.axes == Axes::solid && torque.on.solid != world_name;
    if (const std::string bad = osim_function_complaint(torque.factor); !bad.empty())
      return "forces and torques that " + bad + ", are not written";
    if (in_solid && torque.reaction && torque.reaction->solid != world_name)
      return "forces and torques with a reaction in the axes of another solid are not written";
    if (torque.on.solid != world_name)
      prescribe({torque.on.solid, {}}, torque.torque, in_solid, torque.factor, "torque");
    if (torque.reaction && torque.reaction->solid != world_name)
      prescribe({torque.reaction->solid, {}}, -torque.torque, false, torque.factor, "torque");
    return "";
  }

  void prescribe(const SolidPoint& at, const Vector3d& given, bool in_solid, const TimeFunction& factor,
                 const std::string& what) {
    XmlNode& node = object("PrescribedForce");
    node.add("socket_frame", names_.path(at.solid));
    node.add("pointIsGlobal", "false");
    node.add("forceIsGlobal", in_solid ? "false" : "true");
    const Vector3d v = in_solid ? given : names_.in_ground(given);
    XmlNode& functions = function_set(node, what + "Functions");
    for (int i = 0; i < 3; ++i)
      write_osim_function(functions, scaled(factor, v[i]), fmt::format("{}_{}", what, "xyz"[i]));
    if (what != "force") return;
    XmlNode& point = function_set(node, "pointFunctions");
    for (int i = 0; i < 3; ++i)
      write_osim_function(point, constant(at.point[i]), fmt::format("point_{}", "xyz"[i]));
  }

  static XmlNode& function_set(XmlNode& node, const std::string& name) {
    return node.add("FunctionSet").set("name", name).add("objects");
  }

  const OsimNames& names_;
  XmlNode& objects_;
  std::string name_;
  std::set<std::string> taken_;
  std::map<std::string, Range> ranges_;  // of scalar coordinates
};

class OsimConstraintWriter {
 public:
  OsimConstraintWriter(const OsimNames& names, XmlNode& objects) : names_(names), objects_(objects) {}

  std::string write(const std::string& name, const ConstraintKind& kind) {
    name_ = OsimNames::make(name, taken_);
    return std::visit([&](const auto& constraint) { return add(constraint); }, kind);
  }

 private:
  XmlNode& object(const char* kind) {
    XmlNode& node = objects_.add(kind).set("name", name_);
    node.add("isEnforced", "true");
    return node;
  }

  template <class Kind>
  std::string add(const Kind&) {
    if constexpr (Unilateral<Kind>)
      return fmt::format("constraints of kind {} are not written; OpenSim's contacts and stops are compliant",
                         Kind::kind);
    else
      return fmt::format("constraints of kind {} are not written; OpenSim has none", Kind::kind);
  }

  XmlNode& two_points(const char* kind, const SolidPoint& a, const SolidPoint& b) {
    XmlNode& node = object(kind);
    node.add("socket_body_1", names_.path(a.solid));
    node.add("socket_body_2", names_.path(b.solid));
    node.add("location_body_1", osim_vector_text(names_.point(a)));
    node.add("location_body_2", osim_vector_text(names_.point(b)));
    return node;
  }

  std::string add(const PointOnPoint& joint) {
    two_points("PointConstraint", joint.a, joint.b);
    return "";
  }

  std::string add(const Distance& rod) {
    if (!is_constant(rod.distance)) return "rods whose length changes with time are not written";
    two_points("ConstantDistanceConstraint", rod.a, rod.b)
        .add("constant_distance", exact_text(at(rod.distance, 0).value));
    return "";
  }

  std::string add(const PointOnLine& slot) {
    XmlNode& node = object("PointOnLineConstraint");
    node.add("socket_line_body", names_.path(slot.line.solid));
    node.add("socket_follower_body", names_.path(slot.point.solid));
    node.add("line_direction_vec",
             osim_vector_text(slot.line.solid == world_name ? names_.in_ground(slot.axis) : slot.axis));
    node.add("point_on_line", osim_vector_text(names_.point(slot.line)));
    node.add("point_on_follower", osim_vector_text(names_.point(slot.point)));
    return "";
  }

  // Frame 1, in b, and frame 2, in a, coincide.
  std::string add(const WeldConstraint& weld) {
    XmlNode& node = object("WeldConstraint");
    node.add("socket_frame1", name_ + "_frame1");
    node.add("socket_frame2", name_ + "_frame2");
    XmlNode& frames = node.add("frames");
    write_osim_frame(frames, name_ + "_frame1", names_.path(weld.b.solid),
                     names_.in_frame(weld.b.solid, weld.pose));
    write_osim_frame(frames, name_ + "_frame2", names_.path(weld.a.solid),
                     names_.in_frame(weld.a.solid, Pose{}));
    return "";
  }

  std::string add(const CoordinateFunction& gear) {
    if (const std::string bad = osim_function_complaint(gear.function); !bad.empty())
      return "gears that " + bad + ", are not written";
    write_osim_coupler(objects_, name_, names_.coordinate(gear.on.coordinate),
                       names_.coordinate(gear.of.coordinate), gear.function);
    return "";
  }

  // The first coordinate is a linear function of the others.
  std::string add(const CoordinateCoupling& gear) {
    if (!is_constant(gear.value)) return "couplings whose value changes with time are not written";
    if (gear.coordinates.size() < 2 || gear.ratios[0] == 0)
      return "couplings of one coordinate are not written";
    XmlNode& node = object("CoordinateCouplerConstraint");
    std::string others;
    std::vector<double> coefficients;
    for (std::size_t i = 1; i < gear.coordinates.size(); ++i) {
      others += (i > 1 ? " " : "") + names_.coordinate(gear.coordinates[i].coordinate);
      coefficients.push_back(-gear.ratios[i] / gear.ratios[0]);
    }
    coefficients.push_back(at(gear.value, 0).value / gear.ratios[0]);
    node.add("coupled_coordinates_function")
        .add("LinearFunction")
        .add("coefficients", exact_text(coefficients));
    node.add("independent_coordinate_names", others);
    node.add("dependent_coordinate_name", names_.coordinate(gear.coordinates[0].coordinate));
    node.add("scale_factor", "1");
    return "";
  }

  const OsimNames& names_;
  XmlNode& objects_;
  std::string name_;
  std::set<std::string> taken_;
};

class OsimContactShapes {
 public:
  OsimContactShapes(const OsimNames& names, XmlNode& objects) : names_(names), objects_(objects) {}

  void add(const std::string& name, const ConstraintKind& kind) {
    if (const auto* one = std::get_if<SphereOverPlane>(&kind)) {
      if (one->radius > 0) sphere(name + "_sphere", one->sphere, one->radius);
      half_space(name + "_plane", one->plane);
    } else if (const auto* two = std::get_if<SphereOverSphere>(&kind)) {
      sphere(name + "_a", two->a, two->radii.a);
      sphere(name + "_b", two->b, two->radii.b);
    }
  }

 private:
  XmlNode& shape(const char* kind, const std::string& name, const std::string& solid, const Vector3d& p,
                 const Eigen::Matrix3d& R) {
    XmlNode& node = objects_.add(kind).set("name", OsimNames::make(name, taken_));
    const Pose X = names_.in_frame(solid, {R, p});
    node.add("socket_frame", names_.path(solid));
    node.add("location", osim_vector_text(X.p));
    node.add("orientation", osim_angles_text(X.R));
    return node;
  }

  void sphere(const std::string& name, const SolidPoint& at, double radius) {
    shape("ContactSphere", name, at.solid, at.point, Eigen::Matrix3d::Identity())
        .add("radius", exact_text(radius));
  }

  // OpenSim's half space is solid where its own x is positive.
  void half_space(const std::string& name, const Plane& plane) {
    const Eigen::Matrix3d R = rotation_between(Vector3d::UnitX(), -plane.normal);
    shape("ContactHalfSpace", name, plane.on.solid, plane.on.point, R);
  }

  const OsimNames& names_;
  XmlNode& objects_;
  std::set<std::string> taken_;
};

}  // namespace

std::string osim_vector_text(const Vector3d& v) { return exact_text(std::vector{v.x(), v.y(), v.z()}); }

std::string osim_angles_text(const Eigen::Matrix3d& R) {
  // R = Rx(a) Ry(b) Rz(c); where a is not determined, c makes up for it
  const double a = std::atan2(-R(1, 2), R(2, 2)), s = std::sin(a), c = std::cos(a);
  return osim_vector_text({a, std::atan2(R(0, 2), std::hypot(R(1, 2), R(2, 2))),
                           std::atan2(c * R(1, 0) + s * R(2, 0), c * R(1, 1) + s * R(2, 1))});
}

XmlNode& write_osim_frame(XmlNode& holder, const std::string& name, const std::string& path, const Pose& X) {
  XmlNode& frame = holder.add("PhysicalOffsetFrame").set("name", name);
  frame.add("socket_parent", path);
  frame.add("translation", osim_vector_text(X.p));
  frame.add("orientation", osim_angles_text(X.R));
  return frame;
}

void write_osim_forces(const Scene& scene, const OsimNames& names, XmlNode& objects, Omissions& lost) {
  OsimForceWriter writer(scene, names, objects);
  for (const Effort& effort : scene.efforts) {
    const std::string why = writer.write(effort.name, effort.kind);
    if (!why.empty()) lost.add(why, effort.name);
  }
}

void write_osim_constraints(const Scene& scene, const OsimNames& names, XmlNode& objects, Omissions& lost) {
  OsimConstraintWriter writer(names, objects);
  for (const Constraint& constraint : scene.constraints) {
    const std::string why = writer.write(constraint.name, constraint.kind);
    if (!why.empty()) lost.add(why, constraint.name);
  }
}

void write_osim_coupler(XmlNode& objects, const std::string& name, const std::string& on,
                        const std::string& of, const TimeFunction& by) {
  XmlNode& node = objects.add("CoordinateCouplerConstraint").set("name", name);
  node.add("isEnforced", "true");
  write_osim_function(node.add("coupled_coordinates_function"), by, "function");
  node.add("independent_coordinate_names", of);
  node.add("dependent_coordinate_name", on);
  node.add("scale_factor", "1");
}

void write_osim_contact_shapes(const Scene& scene, const OsimNames& names, XmlNode& objects) {
  OsimContactShapes shapes(names, objects);
  for (const Constraint& constraint : scene.constraints) shapes.add(constraint.name, constraint.kind);
}

}  // namespace borelli
