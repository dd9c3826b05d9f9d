#include "dynamics/formats/mjcf_contact.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "dynamics/formats/mjcf_edit.hpp"
#include "dynamics/scene/convex.hpp"
#include "process/memory.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Limit of contact rows times coordinates: the size of each of about ten dense matrices.
constexpr double most_contact_numbers = 2e6;

// Limit of contact rows if convex pairs are among them (up to 24 rows each): the solver keeps the products of
// all rows with each other as a dense matrix.
constexpr double most_contact_rows = 6000;

int dimensions_of(const XmlElement& element) {
  const double condim = element.number("condim", 3);
  if (condim != 1 && condim != 3 && condim != 4 && condim != 6)
    element.refuse("condim", fmt::format("condim is {:g}, expected 1, 3, 4 or 6", condim));
  return int(condim);
}

unsigned mask_of(const XmlElement& element, const char* key) {
  const double mask = element.number(key, 1);
  if (!(std::abs(mask) < 4e9)) element.refuse(key, fmt::format("{} is {:g}, expected 32 bits", key, mask));
  return unsigned(static_cast<long long>(mask));
}

double friction_of(const XmlElement& element, std::size_t most) {
  const auto friction = element.numbers("friction", 1, most);
  if (friction.empty()) return 1;
  if (friction[0] < 0) element.refuse("friction", "is negative; expected 0 or more");
  return friction[0];
}

Touchable touchable(const std::string& words, const std::string& solid, const MjcfGeom& geom) {
  Touchable out{.name = words, .solid = solid, .plane = {}, .core = {}};
  if (geom.plane) out.plane = Plane{{solid, geom.plane->p}, geom.plane->R.col(2)};
  if (geom.shape) out.core = core_of(geom.shape->shape);
  return out;
}

/// What collides: the shape, or the hull of a mesh; null: none.
const Shape* form_of(const MjcfGeom& geom) {
  return geom.shape ? &geom.shape->shape : geom.hull ? &*geom.hull : nullptr;
}

/// Whether the geom is a sphere or a capsule.
bool is_rounded(const MjcfGeom& geom) {
  return geom.shape && (std::holds_alternative<Sphere>(geom.shape->shape.form) ||
                        std::holds_alternative<Capsule>(geom.shape->shape.form));
}

/// The contact of two spheres or capsules.
ConstraintKind between_rounded(const Touchable& over, const Touchable& under, const ContactSurface& rubs) {
  const ThickSegment &a = *over.core, &b = *under.core;
  const SolidPoint at_a{over.solid, a.centre}, at_b{under.solid, b.centre};
  const Radii radii{a.radius, b.radius};
  if (a.length == 0 && b.length == 0) return SphereOverSphere{at_a, at_b, radii, rubs};
  return CapsuleOverCapsule{at_a, at_b, a.axis, b.axis, a.length, b.length, radii, rubs};
}

enum class Modelled { not_at_all, over_plane, rounded, convex };

Modelled modelled(const MjcfGeom& a, const MjcfGeom& b) {
  const Shape *of_a = form_of(a), *of_b = form_of(b);
  if ((a.plane && of_b) || (b.plane && of_a)) return Modelled::over_plane;
  if (!of_a || !of_b) return Modelled::not_at_all;
  return is_rounded(a) && is_rounded(b) ? Modelled::rounded : Modelled::convex;
}

}  // namespace

MjcfContacts::MjcfContacts(const XmlElement& root) : root_(root) {
  bool pairs = true;
  for (const XmlElement& option : root.children) {
    if (option.name != "option") continue;
    const std::string which = option.word("collision", {"all", "predefined", "dynamic"}, "all");
    any_ = which != "predefined";
    pairs = which != "dynamic";
    if (const XmlElement* flag = option.child("flag"))
      parents_ = flag->word("filterparent", {"enable", "disable"}, "enable") == "disable";
  }
  for (const XmlElement& section : root.children) {
    if (section.name != "contact") continue;
    section.read = true;
    for (const XmlElement& e : section.children) {
      if (e.name == "exclude") {
        e.read = true;
        e.find("name");
        const std::string a = e.require("body1"), b = e.require("body2");
        excluded_.insert({a, b});
        excluded_.insert({b, a});
      } else if (e.name == "pair") {
        e.read = true;
        for (const char* key : {"name", "class"}) e.find(key);
        const std::string a = e.require("geom1"), b = e.require("geom2");
        const Rubbing rubs{friction_of(e, 5), dimensions_of(e)};
        pairs_.push_back(&e);
        if (pairs && paired_.try_emplace({a, b}, rubs).second) paired_.try_emplace({b, a}, rubs);
      }
    }
  }
}

void MjcfContacts::add(const XmlElement& element, const MjcfGeom& geom, const Body& body) {
  Surface s;
  s.name = element.text("name");
  s.body = body;
  s.geom = geom;
  s.type = mask_of(element, "contype");
  s.affinity = mask_of(element, "conaffinity");
  s.priority = whole_number(element, "priority", 0);
  s.dimensions = dimensions_of(element);
  s.friction = friction_of(element, 3);
  if (geom.plane && !s.still())
    element.refuse("is a plane of a moving body; only fixed bodies may have planes");
  surfaces_.push_back(std::move(s));
}

std::string MjcfContacts::Surface::words() const {
  if (!name.empty()) return fmt::format("geom '{}'", name);
  return body.solid == world_name ? "a geom of the world" : fmt::format("a geom of '{}'", body.solid);
}

const MjcfContacts::Rubbing* MjcfContacts::pair_of(const Surface& a, const Surface& b) const {
  const auto found = paired_.find({a.name, b.name});
  return found == paired_.end() ? nullptr : &found->second;
}

bool MjcfContacts::may_touch(const Surface& a, const Surface& b) const {
  if (a.body.weld == b.body.weld) return false;
  if (!paired_.empty() && pair_of(a, b)) return true;
  if (!any_) return false;
  if (!(a.type & b.affinity) && !(b.type & a.affinity)) return false;
  if (!excluded_.empty() && excluded_.contains({a.body.name, b.body.name})) return false;
  return parents_ || a.still() || b.still() ||
         (a.body.weld_parent != b.body.weld && b.body.weld_parent != a.body.weld);
}

MjcfContacts::Rubbing MjcfContacts::between(const Surface& a, const Surface& b) const {
  if (const Rubbing* own = pair_of(a, b)) return *own;
  if (a.priority != b.priority) {
    const Surface& first = a.priority > b.priority ? a : b;
    return {first.friction, first.dimensions};
  }
  return {std::max(a.friction, b.friction), std::max(a.dimensions, b.dimensions)};
}

std::vector<ConstraintKind> MjcfContacts::over_plane(const Surface& over, const Plane& plane,
                                                     const ContactSurface& rubs) {
  if (!form_of(over.geom)) return {};
  const Shape& shape = *form_of(over.geom);
  const Matrix3d turn = shape.orientation.toRotationMatrix();
  const SolidPoint centre{over.body.solid, shape.position};
  if (const auto* sphere = std::get_if<Sphere>(&shape.form))
    return {SphereOverPlane{centre, sphere->radius, plane, rubs}};
  if (const auto* capsule = std::get_if<Capsule>(&shape.form))
    return {CapsuleOverPlane{centre, turn.col(2), capsule->length, capsule->radius, plane, rubs}};
  const auto* box = std::get_if<Box>(&shape.form);
  if (!box) return {ConvexOverPlane{{over.body.solid}, shape, plane, rubs, {}}};
  if (turn.isIdentity(1e-12)) return {BoxOverPlane{centre, box->size, plane, rubs}};
  std::vector<ConstraintKind> corners;  // a box rotated in its solid: one contact per corner
  for (int k = 0; k < 8; ++k) {
    const Vector3d side(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5);
    const Vector3d corner = shape.position + turn * side.cwiseProduct(box->size);
    corners.push_back(SphereOverPlane{{over.body.solid, corner}, 0, plane, rubs});
  }
  return corners;
}

// The surfaces that may touch any other. Refuses more pairs of them than fit into memory.
std::vector<const MjcfContacts::Surface*> MjcfContacts::touching(double freedoms, Crowds& crowds) const {
  constexpr std::size_t most_surfaces = 20000;  // every pair is tested
  constexpr double pair_size = 1500;            // bytes
  constexpr const char* remedy = "<flag contact=\"disable\"/> in <option> switches contacts off";
  std::vector<const Surface*> out;
  for (const Surface& s : surfaces_)
    if (s.type || s.affinity || !paired_.empty()) out.push_back(&s);
  if (out.size() > most_surfaces)
    root_.refuse(fmt::format("has {} geoms that may touch others, expected at most {}; {}", out.size(),
                             most_surfaces, remedy));
  std::size_t pairs = 0, contacts = 0, convex = 0;
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!may_touch(*out[i], *out[j])) continue;
      ++pairs;
      const MjcfGeom &a = out[i]->geom, &b = out[j]->geom;
      const Modelled how = modelled(a, b);
      if (how == Modelled::convex)
        convex += std::size_t(std::min(most_contacts(form_of(a)->form), most_contacts(form_of(b)->form)));
      else
        contacts += how != Modelled::not_at_all;
    }
  crowds.rounded = 3. * double(contacts) * freedoms > most_contact_numbers;
  const double rows = 3. * double(contacts + convex);
  crowds.convex = rows * freedoms > most_contact_numbers || rows > most_contact_rows;
  auto room = admit_memory(root_.where(), fmt::format("a model of {} pairs of geoms that may touch", pairs),
                           pair_size * double(pairs));
  if (room) return out;
  room.error().what += fmt::format("; {}", remedy);
  throw XmlRefusal{room.error()};
}

MjcfContacts::Found MjcfContacts::find(UniqueNames names, double freedoms) const {
  for (const XmlElement* pair : pairs_)
    for (const char* key : {"geom1", "geom2"})
      if (std::none_of(surfaces_.begin(), surfaces_.end(),
                       [&](const Surface& s) { return s.name == pair->require(key); }))
        pair->refuse(key, fmt::format("there is no geom named '{}'", pair->require(key)));
  Found out;
  const auto label = [](const Surface& s, const std::string& standard) {
    return s.name.empty() ? standard : s.name;
  };
  Crowds crowds;
  const std::vector<const Surface*> surfaces = touching(freedoms, crowds);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const bool swapped = surfaces[i]->geom.plane.has_value();
      const Surface &under = *surfaces[swapped ? i : j], &over = *surfaces[swapped ? j : i];
      if (!may_touch(under, over)) continue;
      const Rubbing rubs = between(under, over);
      const ContactSurface surface{.friction = rubs.dimensions == 1 ? 0 : rubs.friction};
      const Touchable below = touchable(under.words(), under.body.solid, under.geom),
                      above = touchable(over.words(), over.body.solid, over.geom);
      const Modelled how = modelled(over.geom, under.geom);
      const bool left_out =
          (how == Modelled::rounded && crowds.rounded) || (how == Modelled::convex && crowds.convex);
      std::vector<ConstraintKind> kinds;
      if (how == Modelled::over_plane)
        kinds = over_plane(over, *below.plane, surface);
      else if (how == Modelled::rounded && !left_out)
        kinds = {between_rounded(above, below, surface)};
      else if (how == Modelled::convex && !left_out)
        kinds = {ConvexOverConvex{{over.body.solid},
                                  {under.body.solid},
                                  *form_of(over.geom),
                                  *form_of(under.geom),
                                  surface,
                                  {},
                                  {}}};
      const std::string standard = below.plane ? "plane" : under.body.solid;
      for (ConstraintKind& kind : kinds)
        out.contacts.push_back(
            {names.make(fmt::format("{} over {}", label(over, over.body.solid), label(under, standard))),
             std::move(kind)});
      out.crowded += left_out;
      if (kinds.empty() && !left_out && out.first.first.empty()) out.first = {below.name, above.name};
      if (kinds.empty())
        out.without.push_back({below, above});
      else
        out.twisting += rubs.dimensions > 3;
    }
  return out;
}

}  // namespace borelli
