// Contacts of scenes as MJCF's pairs of geoms.
#include <algorithm>
#include <optional>
#include <string_view>

#include "dynamics/formats/mjcf_compiler.hpp"
#include "dynamics/formats/mjcf_draft.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct TouchingForm {
  std::string solid;
  MjcfForm form;
  bool is_plane() const { return std::string_view(form.type) == "plane"; }
  bool is_point() const { return form.size[0] == 0 && !is_plane(); }
};

TouchingForm rounded_form(const SolidPoint& at, const Vector3d& axis, double length, double radius) {
  if (length == 0) return {at.solid, {"sphere", {Matrix3d::Identity(), at.point}, {radius}}};
  return {at.solid, {"capsule", {turn_from_z(axis), at.point}, {radius, length / 2}}};
}
TouchingForm rounded_form(const SolidPoint& at, double radius) {
  return rounded_form(at, Vector3d::UnitZ(), 0, radius);
}
TouchingForm plane_form(const Plane& plane) {
  return {plane.on.solid, {"plane", {turn_from_z(plane.normal), plane.on.point}, {0, 0, 1}}};
}

// Of a shape; none: a mesh.
std::optional<TouchingForm> shape_form(const SolidName& on, const Shape& shape) {
  MjcfForm form = mjcf_form(shape.form);
  if (!*form.type) return std::nullopt;
  form.X = {shape.orientation.toRotationMatrix(), shape.position};
  return TouchingForm{on.solid, form};
}

struct TouchingPair {
  TouchingForm over, under;
};

// The forms that a constraint keeps apart; none: it is no contact, or one of a mesh.
std::optional<TouchingPair> touching(const ConstraintKind& kind) {
  if (const auto* c = std::get_if<SphereOverPlane>(&kind))
    return TouchingPair{rounded_form(c->sphere, c->radius), plane_form(c->plane)};
  if (const auto* c = std::get_if<CapsuleOverPlane>(&kind))
    return TouchingPair{rounded_form(c->capsule, c->axis, c->length, c->radius), plane_form(c->plane)};
  if (const auto* c = std::get_if<BoxOverPlane>(&kind))
    return TouchingPair{
        {c->box.solid,
         {"box", {Matrix3d::Identity(), c->box.point}, {c->size.x() / 2, c->size.y() / 2, c->size.z() / 2}}},
        plane_form(c->plane)};
  if (const auto* c = std::get_if<SphereOverSphere>(&kind))
    return TouchingPair{rounded_form(c->a, c->radii.a), rounded_form(c->b, c->radii.b)};
  if (const auto* c = std::get_if<CapsuleOverCapsule>(&kind))
    return TouchingPair{rounded_form(c->a, c->axis_a, c->length_a, c->radii.a),
                        rounded_form(c->b, c->axis_b, c->length_b, c->radii.b)};
  if (const auto* c = std::get_if<ConvexOverPlane>(&kind))
    if (const auto over = shape_form(c->convex, c->shape)) return TouchingPair{*over, plane_form(c->plane)};
  if (const auto* c = std::get_if<ConvexOverConvex>(&kind)) {
    const auto over = shape_form(c->a, c->shape_a), under = shape_form(c->b, c->shape_b);
    if (over && under) return TouchingPair{*over, *under};
  }
  return std::nullopt;
}

// The name of the solid's geom of this form; adds it where there is none.
std::string geom_name(MjcfDraft& draft, const TouchingForm& one) {
  auto& drawn = draft.drawn[draft.bodies.at(one.solid)];
  auto found = std::find_if(drawn.begin(), drawn.end(),
                            [&](const MjcfDraft::Drawn& d) { return d.form.looks_like(one.form); });
  if (found == drawn.end()) {
    add_geom(draft, one.solid, one.form);
    found = drawn.end() - 1;
  }
  if (found->name.empty()) {
    found->name = draft.geoms.make(one.is_plane() ? "plane" : one.solid);
    found->node->set("name", found->name);
  }
  return found->name;
}

}  // namespace

bool add_mjcf_contact(MjcfDraft& draft, const Constraint& constraint) {
  const auto pair = touching(constraint.kind);
  if (!pair && (std::holds_alternative<ConvexOverPlane>(constraint.kind) ||
                std::holds_alternative<ConvexOverConvex>(constraint.kind))) {
    draft.lost.add("contacts of meshes are not written", constraint.name);
    return true;
  }
  if (!pair) return false;
  if (pair->under.is_plane() && !draft.still.at(pair->under.solid)) {
    draft.lost.add("contacts over planes that move are not written", constraint.name);
    return true;
  }
  if (pair->over.is_point() || pair->under.is_point()) {
    draft.lost.add("contacts of points are not written; MuJoCo's spheres have a size", constraint.name);
    return true;
  }
  const std::string over = geom_name(draft, pair->over), under = geom_name(draft, pair->under);
  const ContactSurface surface = surface_of(constraint.kind);
  XmlNode& node = draft.contact.add("pair");
  node.set("geom1", over).set("geom2", under).set("condim", surface.friction > 0 ? "3" : "1");
  if (surface.friction > 0)
    node.set("friction", std::vector{surface.friction, surface.friction, 0.005, 1e-4, 1e-4});
  draft.lost.add(surface.restitution > 0 ? "contacts are soft there and do not rebound by their restitution"
                                         : "contacts are soft there",
                 constraint.name);
  return true;
}

}  // namespace borelli
