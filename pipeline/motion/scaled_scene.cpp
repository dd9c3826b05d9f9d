#include "pipeline/motion/scaled_scene.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <variant>

#include "error/printable.hpp"

namespace borelli {

namespace {

Form scaled_form(Form form, double s) {
  std::visit(
      [&]<class F>(F& f) {
        if constexpr (requires { f.size; }) f.size *= s;
        if constexpr (requires { f.radius; }) f.radius *= s;
        if constexpr (requires { f.radii; }) f.radii *= s;
        if constexpr (requires { f.length; }) f.length *= s;
        if constexpr (requires { f.vertices; })
          for (Eigen::Vector3d& vertex : f.vertices) vertex *= s;
      },
      form);
  return form;
}

bool moves(const Switch& one) { return !std::holds_alternative<Fixed>(one.kind); }

/// Up to its last moving switch a joint belongs to the parent, behind it to the solid.
void scale_joint(Solid& solid, double parent, double own) {
  std::size_t behind = 0;
  for (std::size_t i = 0; i < solid.switches.size(); ++i)
    if (moves(solid.switches[i])) behind = i + 1;
  for (std::size_t i = 0; i < solid.switches.size(); ++i) {
    const double s = i < behind || behind == 0 ? parent : own;
    std::visit(
        [s](auto& kind) {
          if constexpr (requires { kind.scale_lengths(s); }) kind.scale_lengths(s);
        },
        solid.switches[i].kind);
  }
}

void scale_masses(Solid& solid, double s, double mass_factor) {
  const double mass = mass_factor * s * s * s;
  for (Inertial& inertial : solid.inertials) {
    inertial.mass *= mass;
    inertial.centre *= s;
    inertial.tensor *= mass * s * s;
  }
  for (ShapeElement& element : solid.shapes) {
    element.shape.form = scaled_form(element.shape.form, s);
    element.shape.position *= s;
    if (element.mass) *element.mass *= mass;
    if (element.density) *element.density *= mass / (s * s * s);
  }
}

/// Scales the points that an effort or constraint names on solids.
struct PointScaling {
  const std::map<std::string, double>& factors;

  double of(const std::string& solid) const {
    const auto found = factors.find(solid);
    return found == factors.end() ? 1 : found->second;
  }
  void operator()(const char*, SolidPoint& at) const { at.point *= of(at.solid); }
  void operator()(const char*, std::optional<SolidPoint>& at) const {
    if (at) at->point *= of(at->solid);
  }
  template <class Other>
  void operator()(const char*, Other&) const {}
};

template <class Listed>
void scale_points(std::vector<Listed>& all, const PointScaling& scaling) {
  for (Listed& one : all)
    std::visit(
        [&]<class Kind>(Kind& kind) {
          if constexpr (!IsCode<Kind>) Kind::fields(kind, scaling);
        },
        one.kind);
}

}  // namespace

ScaledScene scaled(const Scene& scene, const std::vector<double>& factors, double mass_factor) {
  ScaledScene out{scene, {}};
  std::map<std::string, double> by_name;
  for (std::size_t i = 0; i < scene.solids.size(); ++i) by_name[scene.solids[i].name] = factors[i];
  const PointScaling scaling{by_name};
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    Solid& solid = out.scene.solids[i];
    scale_joint(solid, scaling.of(solid.parent), factors[i]);
    scale_masses(solid, factors[i], mass_factor);
  }
  for (Marker& marker : out.scene.markers) marker.at.point *= scaling.of(marker.at.solid);
  scale_points(out.scene.efforts, scaling);
  scale_points(out.scene.constraints, scaling);
  std::vector<std::string> unchanged;
  for (const Effort& effort : scene.efforts) unchanged.push_back(printable(effort.name));
  for (const Constraint& constraint : scene.constraints) unchanged.push_back(printable(constraint.name));
  if (!unchanged.empty())
    out.warnings.push_back(
        fmt::format("efforts and constraints keep their lengths and strengths; their points are scaled: {}",
                    name_list(unchanged)));
  return out;
}

Result<double> total_mass(const Scene& scene) {
  double sum = 0;
  for (const Solid& solid : scene.solids) {
    const auto inertials = inertials_of(solid);
    if (!inertials) return tl::unexpected(inertials.error());
    for (const Inertial& inertial : *inertials) sum += inertial.mass;
  }
  return sum;
}

}  // namespace borelli
