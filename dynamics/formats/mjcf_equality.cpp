#include "dynamics/formats/mjcf_equality.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace borelli {
namespace {

using Eigen::Vector3d;

class EqualityReader {
 public:
  EqualityReader(const std::map<std::string, Pose>& poses, const std::map<std::string, MjcfJoint>& joints)
      : poses_(poses), joints_(joints) {}

  void read(const XmlElement& e) {
    std::optional<ConstraintKind> kind;
    std::string between;
    if (!e.boolean("active", true)) return;
    if (e.name == "joint") {
      kind = coupling(e);
      between = e.text("joint1");
    } else if (e.name == "connect" || e.name == "weld") {
      if (e.has("site1") || e.has("site2")) return;
      kind = e.name == "connect" ? ConstraintKind(connect(e)) : ConstraintKind(weld(e));
      between = fmt::format("{} and {}", e.text("body1"), e.text("body2", world_name));
    }
    if (!kind) return;
    e.read = true;
    e.find("class");
    const std::string name = e.text("name");
    out.push_back({names_.make(name.empty() ? fmt::format("{} of {}", e.name, between) : name), *kind});
  }

  std::vector<Constraint> out;

 private:
  const Pose& pose(const XmlElement& e, const char* key) const {
    const std::string name = key == std::string_view("body2") ? e.text(key, world_name) : e.require(key);
    const auto found = poses_.find(name);
    if (found == poses_.end()) e.refuse(key, fmt::format("there is no body named '{}'", name));
    return found->second;
  }

  PointOnPoint connect(const XmlElement& e) const {
    e.require("anchor");
    const Vector3d anchor = e.vector("anchor", Vector3d::Zero());  // in the frame of body1
    const Pose &X_W1 = pose(e, "body1"), &X_W2 = pose(e, "body2");
    return {{e.text("body1"), anchor}, {e.text("body2", world_name), X_W2.inverse() * (X_W1 * anchor)}};
  }

  // relpose: pose of body2 in body1; a quaternion of zeros means the initial pose of the model.
  WeldConstraint weld(const XmlElement& e) const {
    Pose X_12 = pose(e, "body1").inverse() * pose(e, "body2");
    if (const auto p = e.numbers("relpose", 7, 7); !p.empty()) {
      const Quaternion turn(p[3], p[4], p[5], p[6]);
      if (turn.norm() > 1e-10) X_12 = {rotation_matrix(turn.normalized()), {p[0], p[1], p[2]}};
    }
    e.find("anchor");  // only where MuJoCo measures the error; the welded pose is the same
    return {{e.text("body2", world_name)}, {e.text("body1")}, X_12};
  }

  const MjcfJoint& joint(const XmlElement& e, const char* key) const {
    const auto found = joints_.find(e.require(key));
    if (found == joints_.end() || found->second.coordinate.empty())
      e.refuse(key, fmt::format("there is no hinge or slide named '{}'", e.require(key)));
    return found->second;
  }

  // Expands value + c0 + c1 (x - start) + c2 (x - start)^2 ... in powers of x.
  static Polynomial shifted(const std::vector<double>& c, double start, double value) {
    std::vector<double> out(c.size(), 0);
    for (auto k = c.rbegin(); k != c.rend(); ++k) {  // Horner: multiply by (x - start), add the next
                                                     // coefficient
      for (std::size_t i = out.size(); i-- > 0;) out[i] = (i > 0 ? out[i - 1] : 0) - start * out[i];
      out[0] += *k;
    }
    out[0] += value;
    return {out};
  }

  // q1 - start1 = c0 + c1 (q2 - start2) + c2 (..)^2 ...; without joint2 it is c0.
  ConstraintKind coupling(const XmlElement& e) const {
    std::vector<double> c{0, 1, 0, 0, 0};
    const auto given = e.numbers("polycoef", 1, 5);
    std::copy(given.begin(), given.end(), c.begin());
    const MjcfJoint& first = joint(e, "joint1");
    const bool curved = c[2] != 0 || c[3] != 0 || c[4] != 0;
    if (curved && e.has("joint2")) {
      const MjcfJoint& second = joint(e, "joint2");
      CoordinateFunction tie{{first.coordinate}, {second.coordinate}, shifted(c, second.start, first.start)};
      if (const std::string bad = tie.complaint(); !bad.empty()) e.refuse("joint2", bad);
      return tie;
    }
    if (!e.has("joint2"))
      return CoordinateCoupling{
          .coordinates = {{first.coordinate}}, .ratios = {1}, .value = constant(first.start + c[0])};
    const MjcfJoint& second = joint(e, "joint2");
    return CoordinateCoupling{.coordinates = {{first.coordinate}, {second.coordinate}},
                              .ratios = {1, -c[1]},
                              .value = constant(first.start + c[0] - c[1] * second.start)};
  }

  const std::map<std::string, Pose>& poses_;
  const std::map<std::string, MjcfJoint>& joints_;
  UniqueNames names_;
};

}  // namespace

std::vector<Constraint> read_mjcf_equality(const XmlElement& root, const std::map<std::string, Pose>& poses,
                                           const std::map<std::string, MjcfJoint>& joints) {
  EqualityReader reader(poses, joints);
  for (const XmlElement& section : root.children) {
    if (section.name != "equality") continue;
    section.read = true;
    for (const XmlElement& e : section.children) reader.read(e);
  }
  return std::move(reader.out);
}

}  // namespace borelli
