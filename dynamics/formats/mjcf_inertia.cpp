#include "dynamics/formats/mjcf_inertia.hpp"

#include <fmt/core.h>

namespace borelli {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Inertial stated(const XmlElement& e, const MjcfCompiler& compiler) {
  for (const char* key : {"pos", "mass"}) e.require(key);
  Pose X = compiler.pose_of(e);
  Inertial own;
  own.mass = e.not_negative("mass", 0);
  if (const auto f = e.numbers("fullinertia", 6, 6); !f.empty()) {  // xx yy zz xy xz yz
    if (e.has("diaginertia")) e.refuse("has both diaginertia and fullinertia; expected one of the two");
    if (!X.R.isIdentity(0)) e.refuse("has both fullinertia and an orientation; expected one of the two");
    own.tensor << f[0], f[3], f[4], f[3], f[1], f[5], f[4], f[5], f[2];
  } else {
    own.tensor = e.vector("diaginertia", Vector3d::Zero()).asDiagonal();
  }
  return own.expressed_in(X.R, X.p);
}

// Applies the lower bounds and MuJoCo's balanceinertia: impossible principal moments become their mean.
void put_right(Inertial& inertial, const MjcfCompiler& compiler) {
  inertial.mass = std::max(inertial.mass, compiler.least_mass);
  PrincipalAxes principal = inertial.principal();
  Vector3d& m = principal.moments;  // ascending
  const Vector3d before = m;
  m = m.cwiseMax(compiler.least_inertia);
  if (compiler.balance_inertia && m[0] + m[1] < m[2]) m.setConstant(m.mean());
  if (m != before) inertial.tensor = principal.axes * m.asDiagonal() * principal.axes.transpose();
}

}  // namespace

bool weighs_by_geoms(const XmlElement& body, const MjcfCompilers& compilers) {
  using From = MjcfCompiler::InertiaFromGeom;
  const MjcfCompiler& compiler = compilers.of(body);
  if (body.name != "body" || compiler.inertia_from_geom == From::never) return false;
  return compiler.inertia_from_geom == From::always || !body.child("inertial");
}

Inertial mjcf_inertial(const XmlElement& body, const std::vector<MjcfGeom>& geoms,
                       const MjcfCompilers& compilers) {
  const MjcfCompiler& compiler = compilers.of(body);
  Inertial out;
  const XmlElement* inertial = body.child("inertial");
  if (weighs_by_geoms(body, compilers)) {
    for (const MjcfGeom& geom : geoms)
      if (geom.inertial && geom.group >= compiler.lowest_group && geom.group <= compiler.highest_group)
        out += *geom.inertial;
    if (inertial) inertial->read = false;  // overridden by the geoms: listed as not modelled
  } else if (inertial) {
    out = stated(*inertial, compiler);
  }
  put_right(out, compiler);
  if (out.mass == 0 && out.tensor.isZero(0)) return out;
  if (const auto fine = check_physical(out, "", Extent::may_be_bar_or_point); !fine)
    (inertial ? inertial : &body)
        ->refuse(fmt::format("{}; compiler balanceinertia=\"true\" corrects impossible moments",
                             fine.error().what));
  return out;
}

}  // namespace borelli
