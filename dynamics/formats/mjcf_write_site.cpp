// Markers of scenes as MJCF's sites, springs between points as its tendons.
#include <fmt/core.h>

#include "dynamics/formats/mjcf_draft.hpp"

namespace borelli {
namespace {

class SiteWriter {
 public:
  explicit SiteWriter(MjcfDraft& draft) : draft_(draft) {}

  // The name of the site at a point, for tendons; adds it if there is none. (Our reader turns sites without a
  // tendon into markers.)
  std::string site(const SolidPoint& at, const std::string& wanted) {
    for (const auto& [known, name] : known_[at.solid])
      if (known == at.point) return name;
    known_[at.solid].emplace_back(at.point, add(at, wanted));
    return known_[at.solid].back().second;
  }

  std::string add(const SolidPoint& at, const std::string& wanted) {
    const std::string name = draft_.sites.make(wanted);
    draft_.bodies.at(at.solid)->add("site").set("name", name).set("pos", at.point);
    return name;
  }

  // MuJoCo's tendon along a straight line pulls and pushes as our spring does.
  bool add_spring(const Effort& effort) {
    const auto* spring = std::get_if<PointSpring>(&effort.kind);
    if (!spring || spring->stiffness < 0 || spring->damping < 0 || spring->rest_length < 0) return false;
    XmlNode& tendon = draft_.tendon.add("spatial");
    tendon.set("name", effort.name);
    if (spring->stiffness > 0)
      tendon.set("stiffness", spring->stiffness).set("springlength", spring->rest_length);
    if (spring->damping > 0) tendon.set("damping", spring->damping);
    tendon.add("site").set("site", site(spring->a, effort.name + " a"));
    tendon.add("site").set("site", site(spring->b, effort.name + " b"));
    return true;
  }

 private:
  MjcfDraft& draft_;
  std::map<std::string, std::vector<std::pair<Eigen::Vector3d, std::string>>> known_;  // by solid
};

}  // namespace

void add_mjcf_sites(MjcfDraft& draft) {
  SiteWriter sites(draft);
  for (const Marker& marker : draft.plain.scene.markers) sites.add(marker.at, marker.name);
  for (const Effort* effort : draft.plain.efforts)
    if (!sites.add_spring(*effort)) draft.lost.add("efforts are not written", named_with_kind(*effort));
}

}  // namespace borelli
