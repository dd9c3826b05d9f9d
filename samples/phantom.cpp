#include "samples/phantom.hpp"

#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "samples/phantom_builder.hpp"
#include "samples/phantom_contact.hpp"

namespace borelli {

using Eigen::Matrix3d, Eigen::Matrix4d, Eigen::Vector3d;

// CT numbers typical at 120 kV. None lies where the curve schneider2000 falls (100 to 101 HU).
namespace tissue {
const PhantomTissue air{"air", -1000}, lung{"lung", -650}, fat{"fat", -100}, brain{"brain", 37},
    blood{"blood", 42}, muscle{"muscle", 45}, liver{"liver", 58}, cartilage{"cartilage", 85},
    spongiosa{"spongiosa", 300}, cortex{"cortex", 1400}, metal{"metal", 3071}, table{"table", -200},
    blanket{"blanket", -300};
}

int PhantomBuilder::add(std::string name, const EllipticStack& shape, const PhantomTissue& tissue, int part) {
  solids.push_back({std::move(name), shape, tissue, curve.at(tissue.hu), part, -1});
  moments.push_back(shape.moments());
  return static_cast<int>(solids.size()) - 1;
}

std::vector<int> PhantomBuilder::nest(const std::string& name, const EllipticStack& shape,
                                      const PhantomTissue& tissue, const std::vector<int>& hosts) {
  std::vector<int> made;
  for (const int host : hosts) {
    if (host < 0) continue;
    const PhantomSolid& outer = solids[static_cast<std::size_t>(host)];
    const auto& limits = outer.shape.cuts();
    if (std::any_of(limits.begin(), limits.end(), [&](const HalfSpace& h) { return shape.side(h) > 0; }))
      continue;
    const EllipticStack cut = shape.cut(limits);
    const Matrix4d integral = cut.moments();
    if (!(integral(3, 3) > 1e-3)) continue;  // mm^3: only its box reaches the host
    const int part = outer.part;
    solids.push_back({name, cut, tissue, curve.at(tissue.hu), part, host});
    moments.push_back(integral);
    made.push_back(static_cast<int>(solids.size()) - 1);
  }
  return made;
}

std::vector<int> PhantomBuilder::bone(const std::string& name, const EllipticStack& shape, double cortex,
                                      const std::vector<int>& hosts) {
  const std::vector<int> made = nest(name, shape, tissue::cortex, hosts);
  nest(name + " spongiosa", shape.shrunk(cortex), tissue::spongiosa, made);
  return made;
}

void PhantomBuilder::mark(const std::string& name, const Vector3d& point) {
  plan.landmarks[name] = {.point = point, .deviation = 0, .radius = 0, .source = "exact"};
}

namespace {

// By part, integrals of density * p pT (mass) and of p pT (volume).
struct Integrals {
  std::array<Matrix4d, parts.size()> mass, volume;
};

// Each solid's density replaces its parent's.
Integrals integrals_of(const PhantomBuilder& builder) {
  Integrals sum;
  sum.mass.fill(Matrix4d::Zero());
  sum.volume.fill(Matrix4d::Zero());
  for (std::size_t i = 0; i < builder.solids.size(); ++i) {
    const PhantomSolid& solid = builder.solids[i];
    const Matrix4d& shape = builder.moments[i];
    sum.mass[static_cast<std::size_t>(solid.part)] += solid.density_kgm3 * shape;
    sum.volume[static_cast<std::size_t>(solid.part)] += shape;
    if (solid.parent < 0) continue;
    const PhantomSolid& parent = builder.solids[static_cast<std::size_t>(solid.parent)];
    sum.mass[static_cast<std::size_t>(parent.part)] -= parent.density_kgm3 * shape;
    sum.volume[static_cast<std::size_t>(parent.part)] -= shape;
  }
  return sum;
}

// kg of all parts; [0] is not part of the body
double mass_of(const PhantomBuilder& builder) {
  const Integrals sum = integrals_of(builder);
  double mass = 0;
  for (std::size_t part = 1; part < parts.size(); ++part) mass += sum.mass[part](3, 3) * 1e-9;
  return mass;
}

// Converts moments from kg/m^3 times mm^3 to mm^5 to an Inertial in m
Inertial inertial(const Matrix4d& moments) {
  Inertial result;
  if (moments(3, 3) <= 0) return result;
  result.mass = moments(3, 3) * 1e-9;
  const Vector3d centre = moments.topRightCorner<3, 1>() / moments(3, 3);
  const Matrix3d second = moments.topLeftCorner<3, 3>() - moments(3, 3) * centre * centre.transpose();
  result.centre = centre * 1e-3;
  result.tensor = (second.trace() * Matrix3d::Identity() - second) * 1e-15;
  return result;
}

struct Built {
  PhantomBuilder builder;
  double flesh_mass = 0, bones_mass = 0;  // kg; the second: added by everything nested in the flesh
};

Built build(const PhantomOptions& options, const BodyPlan& plan, const DensityCurve& curve, double girth,
            bool with_bones) {
  Built built{{plan, curve, girth, options.metal_hip, {}, {}}};
  const Flesh flesh = add_flesh(built.builder);
  built.flesh_mass = mass_of(built.builder);
  if (!with_bones) return built;
  add_organs(built.builder, flesh);
  add_axial_bones(built.builder, flesh);
  for (const int side : {left_side, right_side}) {
    add_arm_bones(built.builder, flesh, side);
    add_leg_bones(built.builder, flesh, side);
  }
  built.bones_mass = mass_of(built.builder) - built.flesh_mass;
  return built;
}

constexpr double least_girth = 0.86, most_girth = 1.40;

// The girth at which the flesh weighs `wanted` kg; empty if there is none. Flesh grows with girth, almost
// quadratically.
std::optional<double> find_girth(const PhantomOptions& options, const BodyPlan& plan,
                                 const DensityCurve& curve, double wanted) {
  const auto flesh = [&](double girth) { return build(options, plan, curve, girth, false).flesh_mass; };
  double low = least_girth, high = most_girth;
  double low_miss = flesh(low) - wanted, high_miss = flesh(high) - wanted;
  if (!(low_miss <= 0 && high_miss >= 0)) return std::nullopt;
  // regula falsi with the Illinois rule: always bracketed, superlinear
  int kept = 0;
  for (int i = 0; i < 60 && high - low > 1e-14; ++i) {
    const double girth = high - high_miss * (high - low) / (high_miss - low_miss),
                 miss = flesh(girth) - wanted;
    if (std::abs(miss) <= 1e-12 * wanted) return girth;
    if (miss < 0) {
      low = girth, low_miss = miss;
      if (kept == -1) high_miss *= 0.5;
      kept = -1;
    } else {
      high = girth, high_miss = miss;
      if (kept == 1) low_miss *= 0.5;
      kept = 1;
    }
  }
  return 0.5 * (low + high);
}

// Mass, kg, at nominal stature and a given girth. Bones and pose depend on the requested mass, which must
// equal the resulting one. Fixed-point iteration converges, since the flesh changes much more than bones and
// pose.
Result<double> mass_at(const PhantomOptions& options, const DensityCurve& curve, double girth) {
  const double nominal = proportions(options).mass_kg;
  double mass = nominal;
  for (int round = 0; round < 8; ++round) {
    const auto plan = plan_body(options, mass / nominal);
    if (!plan) return tl::unexpected(plan.error());
    const Built built = build(options, *plan, curve, girth, true);
    const double before = mass;
    mass = built.flesh_mass + built.bones_mass;
    if (std::abs(mass - before) < 1e-6 * mass) break;
  }
  return mass;
}

// Error that states the possible masses at this stature, rounded inwards to tenths of a kilogram.
Error out_of_range(const PhantomOptions& options, const DensityCurve& curve, double asked, double stature,
                   double cubed) {
  const auto least = mass_at(options, curve, least_girth), most = mass_at(options, curve, most_girth);
  if (!least) return least.error();
  if (!most) return most.error();
  return bad_use("mass", fmt::format("{:g} kg at {:.3f} m is out of range; at this stature the phantom can "
                                     "weigh {:.1f} to {:.1f} kg",
                                     asked, stature, std::ceil(*least * cubed * 10) / 10,
                                     std::floor(*most * cubed * 10) / 10))
      .value();
}

}  // namespace

Result<Phantom> build_phantom(const PhantomOptions& options) {
  if (!options.metal_hip.empty() && options.metal_hip != "left" && options.metal_hip != "right")
    return bad_use("metal hip", fmt::format("'{}' is neither left nor right", options.metal_hip));
  if (options.child && options.sex == Sex::female)
    return bad_use("child", "has the same proportions for girl and boy; leave the sex out");
  const auto curve = density_curve(options.density_curve);
  if (!curve) return tl::unexpected(curve.error());
  // the body is built at its nominal stature, then scaled uniformly
  const double nominal_stature = proportions(options).stature * 1e-3;
  const double nominal_mass = proportions(options).mass_kg;
  const double stature = options.stature_m.value_or(usual_stature(options));
  const double least = options.child ? 0.9 : 1.2, most = options.child ? 1.5 : 2.3;
  if (!(stature >= least && stature <= most))
    return bad_use("stature", fmt::format("{} m is not the stature of a {}; give {} to {} m", stature,
                                          options.child ? "child" : "adult", least, most));
  const double scale = stature / nominal_stature, cubed = scale * scale * scale;
  const double wanted = options.mass_kg.value_or(nominal_mass * cubed) / cubed;
  if (!(wanted > 0 && std::isfinite(wanted)))  // the nominal mass is valid, so this one was requested
    return bad_use("mass", fmt::format("{} kg is not the mass of a body", *options.mass_kg));
  const auto plan = plan_body(options, wanted / nominal_mass);
  if (!plan) return tl::unexpected(plan.error());

  // a few bones depend on the flesh (spinous processes end below the skin), so their mass is found
  // iteratively
  Built built = build(options, *plan, *curve, 1, true);
  for (int round = 0; round < 8; ++round) {
    const double missing = wanted - built.flesh_mass - built.bones_mass;
    if (std::abs(missing) <= 1e-11 * wanted) break;
    const auto girth = find_girth(options, *plan, *curve, wanted - built.bones_mass);
    if (!girth) return tl::unexpected(out_of_range(options, *curve, wanted * cubed, stature, cubed));
    built = build(options, *plan, *curve, *girth, true);
  }
  Phantom phantom;
  phantom.girth = built.builder.girth;
  phantom.landmarks = built.builder.plan.landmarks;
  for (auto& [name, landmark] : phantom.landmarks) landmark.point *= scale, landmark.radius *= scale;
  Integrals sum = integrals_of(built.builder);
  phantom.solids = by_root(std::move(built.builder.solids));
  const std::vector<SharedPlace> shared = shared_places(phantom.solids);
  std::array<double, parts.size()> lost{};  // mm^3 of the nominal body, to other parts
  for (const SharedPlace& place : shared) {
    const PhantomSolid& loser = phantom.solids[place.solid];
    sum.mass[static_cast<std::size_t>(loser.part)] -= loser.density_kgm3 * place.moments;
    sum.volume[static_cast<std::size_t>(loser.part)] -= place.moments;
    const double both = place.moments(3, 3);
    phantom.overlap[static_cast<std::size_t>(loser.part)] += both;
    phantom.overlap[static_cast<std::size_t>(phantom.solids[place.winner].part)] += both;
    lost[static_cast<std::size_t>(loser.part)] += both;
  }
  for (std::size_t part = 1; part < parts.size(); ++part)
    phantom.overlap[part] /= sum.volume[part](3, 3) + lost[part];
  for (PhantomSolid& solid : phantom.solids) solid.shape = solid.shape.scaled(scale);
  const Eigen::Vector4d unit(scale, scale, scale, 1);
  Matrix4d whole = Matrix4d::Zero();
  for (std::size_t part = 1; part < parts.size(); ++part) {
    const Matrix4d scaled = cubed * (unit.asDiagonal() * sum.mass[part] * unit.asDiagonal());
    phantom.exact[part] = inertial(scaled);
    phantom.volume[part] = cubed * sum.volume[part](3, 3) * 1e-9;
    whole += scaled;
  }
  phantom.whole = inertial(whole);
  return phantom;
}

int solid_at(const Phantom& phantom, const Vector3d& point) {
  for (std::size_t i = phantom.solids.size(); i-- > 0;)
    if (phantom.solids[i].shape.holds(point)) return static_cast<int>(i);
  return -1;
}

}  // namespace borelli
