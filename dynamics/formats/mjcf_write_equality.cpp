// Loops and couplings of scenes as MJCF's equalities, which are soft.
#include <fmt/core.h>

#include "dynamics/formats/mjcf_draft.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

constexpr const char* soft_loops = "loops and couplings are soft there (equality)";

class EqualityWriter {
 public:
  explicit EqualityWriter(MjcfDraft& draft) : draft_(draft) {}

  // Whether MJCF has such a constraint; then it is written.
  bool add(const Constraint& constraint) {
    if (const auto* c = std::get_if<PointOnPoint>(&constraint.kind)) return add_connect(constraint.name, *c);
    if (const auto* c = std::get_if<WeldConstraint>(&constraint.kind)) return add_weld(constraint.name, *c);
    if (const auto* c = std::get_if<CoordinateCoupling>(&constraint.kind))
      return add_coupling(constraint.name, *c);
    if (const auto* c = std::get_if<CoordinateFunction>(&constraint.kind))
      return add_function(constraint.name, *c);
    return false;
  }

 private:
  bool add_connect(const std::string& name, const PointOnPoint& loop) {
    const bool swapped = loop.a.solid == world_name;
    const SolidPoint &a = swapped ? loop.b : loop.a, &b = swapped ? loop.a : loop.b;
    const double apart = (draft_.poses.at(a.solid) * a.point - draft_.poses.at(b.solid) * b.point).norm();
    constexpr double closed = 1e-9;  // m, of a loop that an assembly has closed
    if (apart > closed)
      draft_.lost.add("loops that are open at the start close there where the first point is",
                      fmt::format("{} ({:.3g} m)", name, apart));
    XmlNode& node = draft_.equality.add("connect");
    node.set("name", name).set("body1", a.solid);
    if (b.solid != world_name) node.set("body2", b.solid);
    node.set("anchor", a.point);
    draft_.lost.add(soft_loops, name);
    return true;
  }

  // MJCF's body2 stands in body1 at relpose.
  bool add_weld(const std::string& name, const WeldConstraint& weld) {
    const bool swapped = weld.b.solid == world_name;
    const Pose X = swapped ? weld.pose.inverse() : weld.pose;
    const std::string &first = swapped ? weld.a.solid : weld.b.solid,
                      &second = swapped ? weld.b.solid : weld.a.solid;
    const Quaternion q = quaternion(X.R);
    XmlNode& node = draft_.equality.add("weld");
    node.set("name", name).set("body1", first);
    if (second != world_name) node.set("body2", second);
    node.set("relpose", std::vector{X.p.x(), X.p.y(), X.p.z(), q[0], q[1], q[2], q[3]});
    draft_.lost.add(soft_loops, name);
    return true;
  }

  // sum ratio q = value, of one or two coordinates
  bool add_coupling(const std::string& name, const CoordinateCoupling& tie) {
    const auto value = polynomial(tie.value, 0);
    if (!value || tie.coordinates.size() > 2 || tie.ratios[0] == 0) return false;
    const double start = value->at(0) / tie.ratios[0];
    if (tie.coordinates.size() == 1) return add_tie(name, tie.coordinates[0].coordinate, "", {start});
    return add_tie(name, tie.coordinates[0].coordinate, tie.coordinates[1].coordinate,
                   {start, -tie.ratios[1] / tie.ratios[0]});
  }

  bool add_function(const std::string& name, const CoordinateFunction& tie) {
    const auto c = polynomial(tie.function, 4);
    return c && add_tie(name, tie.on.coordinate, tie.of.coordinate, *c);
  }

  // on = c0 + c1 of + c2 of^2 ...; MJCF measures both from their starts.
  bool add_tie(const std::string& name, const std::string& on, const std::string& of, std::vector<double> c) {
    const auto first = draft_.refs.find(on), second = draft_.refs.find(of);
    if (first == draft_.refs.end() || (!of.empty() && second == draft_.refs.end())) return false;
    const double x = of.empty() ? 0 : second->second;
    for (std::size_t i = 0; i < c.size(); ++i)  // Taylor's shift by x: Horner's scheme, repeatedly
      for (std::size_t k = c.size() - 1; k > i; --k) c[k - 1] += x * c[k];
    c[0] -= first->second;
    c.resize(5, 0);
    XmlNode& node = draft_.equality.add("joint");
    node.set("name", name).set("joint1", on);
    if (!of.empty()) node.set("joint2", of);
    node.set("polycoef", c);
    draft_.lost.add(soft_loops, name);
    return true;
  }

  MjcfDraft& draft_;
};

}  // namespace

void add_mjcf_constraints(MjcfDraft& draft) {
  EqualityWriter equalities(draft);
  for (const Constraint* constraint : draft.plain.constraints)
    if (!add_mjcf_contact(draft, *constraint) && !equalities.add(*constraint))
      draft.lost.add("constraints are not written", named_with_kind(*constraint));
}

}  // namespace borelli
