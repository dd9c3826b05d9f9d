#include "dynamics/formats/mjcf_site.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <optional>

namespace borelli {
namespace {

using Eigen::Vector3d;

// The sites at the ends of a straight tendon. None: it bends around something, or does more than a spring.
std::optional<std::array<std::string, 2>> ends_of(const XmlElement& tendon) {
  if (tendon.name != "spatial" || tendon.part != 0 || tendon.children.size() != 2) return std::nullopt;
  for (const XmlAttribute& a : tendon.attributes)
    if (a.name == "range" || a.name == "limited" || a.name == "frictionloss" || a.name == "armature" ||
        a.name == "actuatorfrcrange")
      return std::nullopt;
  std::array<std::string, 2> ends;
  for (std::size_t i = 0; i < 2; ++i) {
    const XmlElement& end = tendon.children[i];
    if (end.name != "site") return std::nullopt;
    for (const XmlAttribute& a : end.attributes)
      if (a.name == "site") ends[i] = a.value;
  }
  return ends;
}

}  // namespace

MjcfSites::MjcfSites(const XmlElement& root) {
  for (const XmlElement& section : root.children)
    if (section.name == "tendon")
      for (const XmlElement& tendon : section.children)
        for (const XmlElement& point : tendon.children)
          for (const XmlAttribute& a : point.attributes)
            if (point.name == "site" && a.name == "site") on_tendons_.insert(a.value);
}

void MjcfSites::read(const XmlElement& body, const std::string& solid, std::vector<Marker>& markers) {
  for (const XmlElement& site : body.children) {
    if (site.name != "site" || !site.has("name")) continue;
    const std::string name = site.text("name");
    SolidPoint at{solid, site.vector("pos", Vector3d::Zero())};
    if (const auto ends = site.numbers("fromto", 6, 6); !ends.empty())
      at.point = {(ends[0] + ends[3]) / 2, (ends[1] + ends[4]) / 2, (ends[2] + ends[5]) / 2};
    if (!points_.emplace(name, at).second) continue;  // (MuJoCo refuses the second one of a name)
    site.read = true;
    site.find("class");
    if (!on_tendons_.contains(name)) markers.push_back({name, at, site.line});
  }
}

void MjcfSites::add_springs(const XmlElement& root, const std::map<std::string, Pose>& poses,
                            const MjcfJoints::Acting& acting, std::vector<Effort>& efforts) const {
  UniqueNames names;
  for (const Effort& effort : efforts) names.take(effort.name);
  for (const XmlElement& section : root.children) {
    if (section.name != "tendon") continue;
    for (const XmlElement& tendon : section.children) {
      const auto ends = ends_of(tendon);
      if (!ends) continue;
      const auto a = points_.find((*ends)[0]), b = points_.find((*ends)[1]);
      const auto stiffness = tendon.numbers("stiffness", 1, 3), damping = tendon.numbers("damping", 1, 3),
                 rest = tendon.numbers("springlength", 1, 2);
      const bool straight_line = stiffness.size() <= 1 && damping.size() <= 1 && rest.size() <= 1;
      if (a == points_.end() || b == points_.end() || !straight_line) continue;
      section.read = tendon.read = true;
      for (const char* key : {"name", "class"}) tendon.find(key);
      for (const XmlElement& end : tendon.children) end.read = true, end.find("site");
      const SolidPoint &from = a->second, &to = b->second;
      PointSpring spring{.a = from, .b = to};
      if (!stiffness.empty() && acting.springs) spring.stiffness = stiffness[0];
      if (!damping.empty() && acting.dampers) spring.damping = damping[0];
      spring.rest_length = !rest.empty() && rest[0] >= 0
                               ? rest[0]
                               : (poses.at(from.solid) * from.point - poses.at(to.solid) * to.point).norm();
      if (spring.stiffness == 0 && spring.damping == 0) continue;
      const std::string name = tendon.text("name");
      efforts.push_back(
          {names.make(name.empty() ? fmt::format("tendon of {} and {}", a->first, b->first) : name), spring,
           tendon.line});
    }
  }
}

void read_mjcf_start(const XmlElement& root, Scene& scene) {
  for (const XmlElement& section : root.children) {
    if (section.name != "keyframe") continue;
    for (const XmlElement& key : section.children) {
      if (key.name != "key" || key.part != 0 || key.text("name") != mjcf_start) continue;
      section.read = key.read = true;
      std::size_t nq = 0, nv = 0;
      std::vector<Switch*> free;
      for (Solid& solid : scene.solids)
        for (Switch& one : solid.switches)
          if (const auto [q, v] = std::visit([](const auto& k) { return std::pair(k.nq, k.nv); }, one.kind);
              v > 0) {
            free.push_back(&one);
            nq += std::size_t(q);
            nv += std::size_t(v);
          }
      const auto qpos = key.numbers("qpos", nq, nq), qvel = key.numbers("qvel", nv, nv);
      auto q = qpos.begin(), v = qvel.begin();
      for (Switch* one : free) {
        const auto [n, m] = std::visit([](const auto& k) { return std::pair(k.nq, k.nv); }, one->kind);
        if (!qpos.empty()) one->q.assign(q, q + n), q += n;
        if (!qvel.empty()) one->v.assign(v, v + m), v += m;
      }
      return;
    }
  }
}

}  // namespace borelli
