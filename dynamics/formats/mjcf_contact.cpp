#include "dynamics/formats/mjcf_contact.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>

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

double friction_of(const XmlElement& element) {
  const auto friction = element.numbers("friction", 1, 3);
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

constexpr const char* remedy = "<flag contact=\"disable\"/> in <option> switches contacts off";

}  // namespace

// The friction of a pair, or of all contacts: two sliding directions, then turning and rolling. Missing
// numbers have MuJoCo's defaults.
MjcfContacts::Rubbing MjcfContacts::rubbing_of(const XmlElement& e, const char* friction) {
  const auto given = e.numbers(friction, 1, 5);
  Rubbing out{.friction = given.empty() ? 1 : given[0]};
  const double across = given.size() > 1 ? given[1] : 1;
  if (out.friction < 0 || across < 0) e.refuse(friction, "is negative; expected 0 or more");
  out.directed = across != out.friction;
  return out;
}

MjcfContacts::MjcfContacts(const XmlElement& root) : root_(root) {
  bool pairs = true;
  for (const XmlElement& option : root.children) {
    if (option.name != "option") continue;
    const std::string which = option.word("collision", {"all", "predefined", "dynamic"}, "all");
    any_ = which != "predefined";
    pairs = which != "dynamic";
    const XmlElement* flag = option.child("flag");
    if (!flag) continue;
    parents_ = flag->word("filterparent", {"enable", "disable"}, "enable") == "disable";
    if (flag->word("override", {"enable", "disable"}, "disable") == "enable")
      override_ = rubbing_of(option, "o_friction");
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
        Rubbing rubs = rubbing_of(e, "friction");
        rubs.dimensions = dimensions_of(e);
        pairs_.push_back(&e);
        if (pairs && paired_.try_emplace({a, b}, rubs).second) paired_.try_emplace({b, a}, rubs);
      }
    }
  }
}

MjcfContacts::Modelled MjcfContacts::modelled(const Surface& a, const Surface& b) {
  if (a.extent == Extent::none || b.extent == Extent::none) return Modelled::not_at_all;
  if (a.extent == Extent::plane || b.extent == Extent::plane)
    return a.extent == b.extent ? Modelled::not_at_all : Modelled::over_plane;
  return a.extent == Extent::rounded && b.extent == Extent::rounded ? Modelled::rounded : Modelled::convex;
}

void MjcfContacts::add(const XmlElement& element, const MjcfGeom& geom, const Body& body) {
  Surface s;
  s.name = element.text("name");
  s.body = body;
  s.weld = number_of(body.weld), s.weld_parent = number_of(body.weld_parent);
  s.geom = geom;
  if (form_of(geom)) s.extent = is_rounded(geom) ? Extent::rounded : Extent::convex;
  if (geom.plane) s.extent = Extent::plane;
  s.type = mask_of(element, "contype");
  s.affinity = mask_of(element, "conaffinity");
  s.priority = whole_number(element, "priority", 0);
  s.dimensions = dimensions_of(element);
  s.friction = friction_of(element);
  if (geom.plane && !s.still())
    element.refuse("is a plane of a moving body; only fixed bodies may have planes");
  surfaces_.push_back(std::move(s));
}

int MjcfContacts::number_of(const std::string& weld) {
  return welds_.try_emplace(weld, int(welds_.size())).first->second;
}

std::string MjcfContacts::Surface::words() const {
  if (!name.empty()) return fmt::format("geom '{}'", name);
  return body.solid == world_name ? "a geom of the world" : fmt::format("a geom of '{}'", body.solid);
}

const MjcfContacts::Rubbing* MjcfContacts::pair_of(const Surface& a, const Surface& b) const {
  if (paired_.empty()) return nullptr;
  const auto found = paired_.find({a.name, b.name});
  return found == paired_.end() ? nullptr : &found->second;
}

bool MjcfContacts::may_touch(const Surface& a, const Surface& b) const {
  if (a.weld == b.weld) return false;
  if (pair_of(a, b)) return true;
  if (!any_) return false;
  if (!(a.type & b.affinity) && !(b.type & a.affinity)) return false;
  if (!excluded_.empty() && excluded_.contains({a.body.name, b.body.name})) return false;
  return parents_ || a.still() || b.still() || (a.weld_parent != b.weld && b.weld_parent != a.weld);
}

MjcfContacts::Rubbing MjcfContacts::between(const Surface& a, const Surface& b) const {
  const auto with_override = [&](Rubbing own) {
    if (override_) own.friction = override_->friction, own.directed = override_->directed;
    return own;
  };
  if (const Rubbing* own = pair_of(a, b)) return with_override(*own);
  if (a.priority != b.priority) {
    const Surface& first = a.priority > b.priority ? a : b;
    return with_override({first.friction, first.dimensions});
  }
  return with_override({std::max(a.friction, b.friction), std::max(a.dimensions, b.dimensions)});
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

// The surfaces that may touch any other.
std::vector<const MjcfContacts::Surface*> MjcfContacts::touching() const {
  constexpr std::size_t most_surfaces = 20000;  // every pair is tested
  std::vector<const Surface*> out;
  for (const Surface& s : surfaces_)
    if (s.type || s.affinity || !paired_.empty()) out.push_back(&s);
  if (out.size() > most_surfaces)
    root_.refuse(fmt::format("has {} geoms that may touch others, expected at most {}; {}", out.size(),
                             most_surfaces, remedy));
  return out;
}

MjcfContacts::LeftOut MjcfContacts::left_out(const std::vector<const Surface*>& surfaces,
                                             double freedoms) const {
  constexpr double contact_size = 1500, size_without = sizeof(std::pair<int, int>);  // bytes
  std::array<std::size_t, 4> pairs{};                                                // by Modelled
  std::size_t convex = 0;  // contacts of convex pairs
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!may_touch(*surfaces[i], *surfaces[j])) continue;
      const Modelled how = modelled(*surfaces[i], *surfaces[j]);
      ++pairs[std::size_t(how)];
      if (how != Modelled::convex) continue;
      const Shape *a = form_of(surfaces[i]->geom), *b = form_of(surfaces[j]->geom);
      convex += std::size_t(std::min(most_contacts(a->form), most_contacts(b->form)));
    }
  const auto [unknown, over_planes, rounded, convex_pairs] = pairs;
  const std::size_t contacts = over_planes + rounded;
  const double rows = 3. * double(contacts + convex);
  LeftOut out;
  out.rounded = 3. * double(contacts) * freedoms > most_contact_numbers;
  out.convex = rows * freedoms > most_contact_numbers || rows > most_contact_rows;
  out.pairs = unknown + (out.rounded ? rounded : 0) + (out.convex ? convex_pairs : 0);
  const std::size_t all = contacts + unknown + convex_pairs;
  auto room = admit_memory(root_.where(), fmt::format("a model of {} pairs of geoms that may touch", all),
                           contact_size * double(all - out.pairs) + size_without * double(out.pairs));
  if (room) return out;
  room.error().what += fmt::format("; {}", remedy);
  throw XmlRefusal{room.error()};
}

MjcfContacts::Found MjcfContacts::find(UniqueNames names, double freedoms) const {
  std::set<std::string_view> known;
  for (const Surface& s : surfaces_) known.insert(s.name);
  for (const XmlElement* pair : pairs_)
    for (const char* key : {"geom1", "geom2"})
      if (!known.contains(pair->require(key)))
        pair->refuse(key, fmt::format("there is no geom named '{}'", pair->require(key)));
  Found out;
  const auto label = [](const Surface& s, const std::string& standard) {
    return s.name.empty() ? standard : s.name;
  };
  const std::vector<const Surface*> surfaces = touching();
  const LeftOut too_many = left_out(surfaces, freedoms);
  std::vector<Touchable> touchables;
  for (const Surface* s : surfaces) touchables.push_back(touchable(s->words(), s->body.solid, s->geom));
  out.without.pairs.reserve(too_many.pairs);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const bool swapped = surfaces[i]->geom.plane.has_value();
      const std::size_t lower = swapped ? i : j, upper = swapped ? j : i;
      const Surface &under = *surfaces[lower], &over = *surfaces[upper];
      if (!may_touch(under, over)) continue;
      const Touchable &below = touchables[lower], &above = touchables[upper];
      const Modelled how = modelled(over, under);
      if ((how == Modelled::rounded && too_many.rounded) || (how == Modelled::convex && too_many.convex)) {
        ++out.crowded;
        out.without.pairs.emplace_back(lower, upper);
        continue;
      }
      const Rubbing rubs = between(under, over);
      const ContactSurface surface{.friction = rubs.dimensions == 1 ? 0 : rubs.friction};
      std::vector<ConstraintKind> kinds;
      if (how == Modelled::over_plane)
        kinds = over_plane(over, *below.plane, surface);
      else if (how == Modelled::rounded)
        kinds = {between_rounded(above, below, surface)};
      else if (how == Modelled::convex)
        kinds = {ConvexOverConvex{{over.body.solid},
                                  {under.body.solid},
                                  *form_of(over.geom),
                                  *form_of(under.geom),
                                  surface,
                                  {},
                                  {}}};
      if (kinds.empty()) {
        if (out.first.first.empty()) out.first = {below.name, above.name};
        out.without.pairs.emplace_back(lower, upper);
        continue;
      }
      out.twisting += rubs.dimensions > 3;
      out.directed += rubs.dimensions > 1 && rubs.directed;
      const std::string name =
          fmt::format("{} over {}", label(over, over.body.solid),
                      label(under, below.plane ? std::string("plane") : under.body.solid));
      for (ConstraintKind& kind : kinds) out.contacts.push_back({names.make(name), std::move(kind)});
    }
  if (!out.without.pairs.empty()) out.without.surfaces = std::move(touchables);
  return out;
}

}  // namespace borelli
