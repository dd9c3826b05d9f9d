#include "dynamics/formats/osim_constraint.hpp"

#include <fmt/core.h>

#include <map>
#include <set>
#include <sstream>

#include "dynamics/formats/osim_force.hpp"
#include "dynamics/formats/osim_function.hpp"
#include "dynamics/formats/unique_names.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

class OsimConstraintReader {
 public:
  OsimConstraintReader(const OsimFrames& frames, Scene& scene) : frames_(frames), scene_(scene) {
    for (Solid& solid : scene.solids)
      for (std::size_t i = 0; i < solid.switches.size(); ++i)
        if (const std::string name = coordinate_name(solid, i); !name.empty())
          switches_[name] = &solid.switches[i];
  }

  void read_constraint(const XmlElement& e) {
    std::optional<ConstraintKind> kind;
    if (e.name == "CoordinateCouplerConstraint") {
      kind = coupler(e);
    } else if (e.name == "PointConstraint") {
      kind = PointOnPoint{point(e, "1", "location_body_1"), point(e, "2", "location_body_2")};
    } else if (e.name == "ConstantDistanceConstraint") {
      const XmlElement* distance = e.child("constant_distance");
      Distance rod{point(e, "1", "location_body_1"), point(e, "2", "location_body_2"),
                   constant(distance ? distance->content_numbers(1, 1)[0] : 0)};
      if (const std::string bad = rod.complaint(); !bad.empty()) e.refuse(bad);
      kind = rod;
    } else if (e.name == "WeldConstraint") {
      kind = weld(e);
    } else if (e.name == "PointOnLineConstraint") {
      kind = on_line(e);
    } else {
      return;
    }
    mark(e);
    if (kind) scene_.constraints.push_back({constraint_names_.make(name_of(e)), *kind, e.line});
  }

  std::set<std::string> coordinates() const {
    std::set<std::string> out;
    for (const auto& [name, one] : switches_) out.insert(name);
    return out;
  }

 private:
  static std::string name_of(const XmlElement& e) {
    const std::string name = e.text("name");
    return name.empty() ? e.name : name;
  }
  static void mark(const XmlElement& e) {
    e.read = true;
    for (const char* child : {"isEnforced", "isDisabled"}) e.child(child);
  }
  static double value(const XmlElement& e, std::string_view child) {
    const XmlElement* given = e.child(child);
    return given && !given->content.empty() ? given->content_numbers(1, 1)[0] : 0;
  }
  static SolidPoint at_frame(const OsimFrame& frame, const Vector3d& point) {
    return {frame.solid, frame.X * point};
  }
  SolidPoint point(const XmlElement& e, const std::string& number, std::string_view location) const {
    const std::string socket = "socket_body_" + number, old = "body_" + number;
    return at_frame(frames_.named_by(e, {socket, old}), osim_vector(e, location));
  }

  /// The frame of a body in a weld: a socket's, or in OpenSim 3 a place in the body.
  OsimFrame welded(const XmlElement& e, const std::string& number) const {
    const std::string socket = "socket_frame" + number, old = "body_" + number;
    OsimFrame frame = frames_.named_by(e, {socket, old});
    if (e.child(socket)) return frame;
    frame.X = frame.X * Pose{osim_rotation(osim_vector(e, "orientation_body_" + number)),
                             osim_vector(e, "location_body_" + number)};
    return frame;
  }

  WeldConstraint weld(const XmlElement& e) const {
    const OsimFrame one = welded(e, "1"), two = welded(e, "2");  // they coincide
    return {{two.solid}, {one.solid}, one.X * two.X.inverse()};
  }

  PointOnLine on_line(const XmlElement& e) const {
    const OsimFrame line = frames_.named_by(e, {"socket_line_body", "line_body"});
    const OsimFrame follower = frames_.named_by(e, {"socket_follower_body", "follower_body"});
    const Vector3d direction = osim_vector(e, "line_direction_vec", Vector3d::UnitZ());
    if (!(direction.norm() > 1e-12)) e.refuse("its line has no direction");
    PointOnLine out;
    out.point = at_frame(follower, osim_vector(e, "point_on_follower"));
    out.line = at_frame(line, osim_vector(e, "point_on_line"));
    out.axis = line.X.R * direction.normalized();
    return out;
  }

  /// A coordinate by its name, or a path that ends with it. Refuses one that is not there.
  std::string coordinate(const XmlElement& e, const std::string& path) const {
    const std::string name = path.substr(path.find_last_of('/') + 1);
    if (!switches_.contains(name)) e.refuse(fmt::format("no coordinate is named '{}'", printable(name)));
    return name;
  }

  // dependent = scale_factor f(independent)
  std::optional<ConstraintKind> coupler(const XmlElement& e) {
    const std::string on = coordinate(e, e.require_child("dependent_coordinate_name").content);
    std::istringstream names(e.require_child("independent_coordinate_names").content);
    std::vector<std::string> of;
    for (std::string name; names >> name;) of.push_back(coordinate(e, name));
    if (of.empty()) e.refuse("has no independent coordinate");
    const XmlElement& holder = e.require_child("coupled_coordinates_function");
    const XmlElement* function = osim_function_in(holder);
    if (!function) holder.refuse("contains no function");
    const double scale = e.child("scale_factor") ? value(e, "scale_factor") : 1;
    if (of.size() > 1) return coupling(on, of, *function, scale);
    const TimeFunction f = scaled(read_osim_function(*function), scale);
    if (on == of[0]) e.refuse("couples a coordinate to itself");
    Switch& one = *switches_.at(on);
    if (!std::holds_alternative<Free>(one.motion)) return CoordinateFunction{{on}, {of[0]}, f};
    one.motion = Coupled{of[0], f};
    one.q.clear(), one.v.clear(), one.ranges.clear();
    return {};
  }

  // A linear function of n coordinates has n + 1 coefficients, the constant last.
  static CoordinateCoupling coupling(const std::string& on, const std::vector<std::string>& of,
                                     const XmlElement& function, double scale) {
    if (function.name != "LinearFunction")
      function.refuse("couples a coordinate to several others by a function that is not linear");
    const std::vector<double> c =
        function.require_child("coefficients").content_numbers(of.size() + 1, of.size() + 1);
    CoordinateCoupling out{.coordinates = {{on}}, .ratios = {1}, .value = constant(scale * c.back())};
    for (std::size_t i = 0; i < of.size(); ++i) {
      out.coordinates.push_back({of[i]});
      out.ratios.push_back(-scale * c[i]);
    }
    return out;
  }

  const OsimFrames& frames_;
  Scene& scene_;
  std::map<std::string, Switch*> switches_;
  UniqueNames constraint_names_;
};

}  // namespace

bool osim_acts(const XmlElement& element) {
  return osim_flag(element, "isEnforced", true) && osim_flag(element, "appliesForce", true) &&
         !osim_flag(element, "isDisabled", false);
}

void read_osim_constraints(const XmlElement& model, const OsimFrames& frames, Scene& scene) {
  const std::vector<const XmlElement*> components = osim_components(model);
  const auto each_acting = [&](std::string_view set, auto&& read) {
    for (const auto& list : {osim_objects(model, set), components})
      for (const XmlElement* e : list)
        if (osim_acts(*e)) read(*e);
  };
  OsimConstraintReader reader(frames, scene);
  each_acting("ConstraintSet", [&](const XmlElement& e) { reader.read_constraint(e); });
  OsimForceReader forces(frames, reader.coordinates(), scene);
  each_acting("ForceSet", [&](const XmlElement& e) { forces.read(e); });
}

}  // namespace borelli
