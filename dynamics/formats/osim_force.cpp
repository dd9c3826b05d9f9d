#include "dynamics/formats/osim_force.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <optional>
#include <regex>

#include "dynamics/formats/osim_function.hpp"
#include "error/printable.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// An optional number in an element's child; 0 if there is none.
double force_number(const XmlElement& e, std::string_view child) {
  const XmlElement* given = e.child(child);
  return given && !given->content.empty() ? given->content_numbers(1, 1)[0] : 0;
}

std::string force_expression(const XmlElement& e) {
  for (const XmlElement& c : e.children)  // (stays unread until it is known)
    if (c.name == "expression") {
      std::string text = c.content;
      text.erase(std::remove_if(text.begin(), text.end(), [](unsigned char x) { return std::isspace(x); }),
                 text.end());
      return text;
    }
  return "";
}

// The numbers in an expression of this form, where N is a number, +N one with its sign or nothing.
std::optional<std::vector<double>> expression_numbers(const std::string& expression, std::string_view form) {
  constexpr std::size_t longest_expression = 1000;  // (the matcher recurses)
  if (expression.size() > longest_expression) return {};
  const std::string number = R"([0-9.]+(?:[eE][-+]?[0-9]+)?)";
  std::string pattern;
  for (std::size_t i = 0; i < form.size(); ++i)
    if (form[i] == 'N')
      pattern += "(-?" + number + ")";
    else if (form[i] == '#')
      pattern += "([-+]" + number + ")?";
    else if (std::string_view("()*+").find(form[i]) != std::string_view::npos)
      pattern += std::string("\\") + form[i];
    else
      pattern += form[i];
  std::smatch found;
  if (!std::regex_match(expression, found, std::regex(pattern))) return {};
  std::vector<double> out;
  for (std::size_t i = 1; i < found.size(); ++i)
    out.push_back(found[i].matched ? std::strtod(found[i].str().c_str(), nullptr) : 0);
  return out;
}

// k (d - r) + c d', as write_osim() has it.
std::optional<PointSpring> spring_of(const std::string& expression) {
  const auto found = expression_numbers(expression, "N*(d#)+N*ddot");
  if (!found) return {};
  PointSpring spring;
  spring.stiffness = (*found)[0], spring.rest_length = -(*found)[1], spring.damping = (*found)[2];
  return spring;
}

// The spring of a limit beyond each bound, as write_osim() has it.
std::optional<LimitSpring> limit_of(const std::string& expression) {
  const auto found =
      expression_numbers(expression, "-N*max(0,q#)*max(0,1+N*qdot)+N*max(0,-(q#))*max(0,1-N*qdot)");
  if (!found) return {};
  const auto [k, upper, c, k_too, lower, c_too] =
      std::array{(*found)[0], (*found)[1], (*found)[2], (*found)[3], (*found)[4], (*found)[5]};
  if (k != k_too || c != c_too) return {};
  LimitSpring spring;
  spring.stiffness = k, spring.dissipation = c, spring.range = {{-lower, -upper}};
  return spring.complaint().empty() ? std::optional(spring) : std::nullopt;
}

// The three functions of a set, by the set's name (OpenSim 3 and 4); none: it is missing or empty.
std::vector<TimeFunction> prescribed_functions(const XmlElement& e, std::string_view set) {
  std::vector<TimeFunction> out;
  for (const XmlElement& c : e.children) {
    if (c.name != "FunctionSet" || c.text("name") != set) continue;
    c.read = true;
    c.child("groups");
    if (const XmlElement* objects = c.child("objects"))
      for (const XmlElement& function : objects->children) out.push_back(read_osim_function(function));
  }
  if (!out.empty() && out.size() != 3)
    e.refuse(fmt::format("has {} functions in {}, expected 3", out.size(), set));
  return out;
}

bool never_pushes(const TimeFunction& f) {
  const auto* c = std::get_if<Polynomial>(&f);
  return c && std::all_of(c->coefficients.begin(), c->coefficients.end(), [](double x) { return x == 0; });
}

}  // namespace

void OsimForceReader::read(const XmlElement& e) {
  if (e.name == "PointToPointSpring") {
    PointSpring spring{end(e, "1"), end(e, "2")};
    spring.stiffness = force_number(e, "stiffness"), spring.rest_length = force_number(e, "rest_length");
    add(e, spring);
  } else if (e.name == "SpringGeneralizedForce") {
    CoordinateSpring spring{coordinate(e)};
    spring.stiffness = force_number(e, "stiffness"), spring.damping = force_number(e, "viscosity");
    spring.rest = force_number(e, "rest_length");
    add(e, spring);
  } else if (e.name == "ExpressionBasedPointToPointForce") {
    auto spring = spring_of(force_expression(e));
    if (!spring) return;
    e.child("expression");
    spring->a = end(e, "1"), spring->b = end(e, "2");
    add(e, *spring);
  } else if (e.name == "ExpressionBasedCoordinateForce") {
    auto spring = limit_of(force_expression(e));
    if (!spring) return;
    e.child("expression");
    spring->on.coordinate = coordinate(e).coordinate;
    add(e, *spring);
  } else if (e.name == "PrescribedForce") {
    try {
      read_prescribed(e);
    } catch (const XmlRefusal&) {  // by a function that a scene does not have: unread, so that it is listed
    }
  }
}

// A force or torque along each axis by its own function of time.
void OsimForceReader::read_prescribed(const XmlElement& e) {
  const auto forces = prescribed_functions(e, "forceFunctions"),
             torques = prescribed_functions(e, "torqueFunctions"),
             points = prescribed_functions(e, "pointFunctions");
  const bool moves = !std::all_of(points.begin(), points.end(), is_constant);
  if (osim_flag(e, "pointIsGlobal", false) || moves) return;  // such a point moves in the body
  const Axes axes = osim_flag(e, "forceIsGlobal", true) ? Axes::world : Axes::solid;
  const OsimFrame frame = frames_.named_by(e, {"socket_frame", "body"});
  Vector3d point = Vector3d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) point[Eigen::Index(i)] = at(points[i], 0).value;
  for (int i = 0; i < 3; ++i) {
    const Vector3d along = axes == Axes::solid ? frame.X.R.col(i) : Vector3d(Vector3d::Unit(i));
    const std::string ending = std::string(".") + "xyz"[i];
    if (!forces.empty() && !never_pushes(forces[i]))
      add(e, Force{{frame.solid, frame.X * point}, along, axes, forces[i], {}}, ending);
    if (!torques.empty() && !never_pushes(torques[i]))
      add(e, Torque{{frame.solid}, along, axes, torques[i], {}}, ".torque" + ending);
  }
  e.read = true;
}

void OsimForceReader::add(const XmlElement& e, EffortKind kind, const std::string& ending) {
  e.read = true;
  for (const char* child : {"isDisabled", "appliesForce"}) e.child(child);
  std::string name = e.text("name");
  if (name.empty()) name = e.name;
  scene_.efforts.push_back({names_.make(name + ending), std::move(kind), e.line});
}

CoordinateName OsimForceReader::coordinate(const XmlElement& e) const {
  const std::string& path = e.require_child("coordinate").content;
  const std::string name = path.substr(path.find_last_of('/') + 1);
  if (!coordinates_.contains(name)) e.refuse(fmt::format("no coordinate is named '{}'", printable(name)));
  return {name};
}

SolidPoint OsimForceReader::end(const XmlElement& e, const std::string& number) const {
  const std::string socket = "socket_body" + number, old = "body" + number;
  const OsimFrame frame = frames_.named_by(e, {socket, old});
  return {frame.solid, frame.X * osim_vector(e, "point" + number)};
}

}  // namespace borelli
