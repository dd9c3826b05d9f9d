#include "dynamics/formats/mjcf_compiler.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <numbers>

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

void read_section(const XmlElement& e, MjcfCompiler& c) {
  using From = MjcfCompiler::InertiaFromGeom;
  if (e.word("coordinate", {"local", "global"}, "local") == "global")
    e.refuse("coordinate",
             "global coordinates are not supported; load the model in MuJoCo 2.3.3 or earlier and save it in "
             "local ones");
  c.degrees = e.word("angle", {"degree", "radian"}, c.degrees ? "degree" : "radian") == "degree";
  c.euler_sequence = e.text("eulerseq", c.euler_sequence);
  bool axes = c.euler_sequence.size() == 3;
  for (char axis : c.euler_sequence)
    axes = axes && std::string_view("xyzXYZ").find(axis) != std::string_view::npos;
  if (!axes)
    e.refuse("eulerseq", fmt::format("eulerseq is '{}', expected three of x y z X Y Z", c.euler_sequence));
  c.auto_limits = e.boolean("autolimits", c.auto_limits);
  c.align_free = e.boolean("alignfree", c.align_free);
  if (e.has("inertiafromgeom")) {
    const std::string from = e.word("inertiafromgeom", {"false", "true", "auto"}, "auto");
    c.inertia_from_geom = from == "false" ? From::never : from == "true" ? From::always : From::where_missing;
  }
  if (const auto groups = e.numbers("inertiagrouprange", 2, 2); !groups.empty()) {
    c.lowest_group = static_cast<int>(std::clamp(groups[0], -1e9, 1e9));
    c.highest_group = static_cast<int>(std::clamp(groups[1], -1e9, 1e9));
  }
  c.balance_inertia = e.boolean("balanceinertia", c.balance_inertia);
  c.fit_box = e.boolean("fitaabb", c.fit_box);
  c.exact_mesh_inertia = e.boolean("exactmeshinertia", c.exact_mesh_inertia);
  c.least_mass = e.number("boundmass", c.least_mass);
  c.least_inertia = e.number("boundinertia", c.least_inertia);
  c.total_mass = e.number("settotalmass", c.total_mass);
  c.mesh_folder = e.text("assetdir", c.mesh_folder);
  c.mesh_folder = e.text("meshdir", c.mesh_folder);
  c.strip_path = e.boolean("strippath", c.strip_path);
}

}  // namespace

MjcfCompiler MjcfCompiler::read(const XmlElement& root) {
  MjcfCompiler out;
  out.folder = std::filesystem::path(root.file).parent_path();
  for (const XmlElement& section : root.children)
    if (section.name == "compiler") {
      section.read = true;
      read_section(section, out);
    }
  return out;
}

Matrix3d MjcfCompiler::from_euler(const Vector3d& angles) const {
  Matrix3d R = Matrix3d::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const char axis = euler_sequence[i];
    const bool turns_along = std::islower(static_cast<unsigned char>(axis)) != 0;
    const int number = std::tolower(static_cast<unsigned char>(axis)) - 'x';
    const Matrix3d next = rotation_about(Vector3d::Unit(number), angle(angles[static_cast<Eigen::Index>(i)]));
    R = turns_along ? Matrix3d(R * next) : Matrix3d(next * R);
  }
  return R;
}

double MjcfCompiler::angle(double value) const { return degrees ? value * (std::numbers::pi / 180) : value; }

Pose MjcfCompiler::pose_of(const XmlElement& element) const {
  return {orientation_of(element), element.vector("pos", Vector3d::Zero())};
}

Matrix3d MjcfCompiler::orientation_of(const XmlElement& e) const {
  int given = 0;
  for (const char* key : {"quat", "axisangle", "euler", "xyaxes", "zaxis"}) given += e.has(key);
  if (given > 1) e.refuse("has several orientations; expected one of quat, axisangle, euler, xyaxes, zaxis");
  const auto unit = [&](const char* key, const Vector3d& v) {
    if (v.norm() < 1e-10) e.refuse(key, fmt::format("{} has no direction", key));
    return Vector3d(v.normalized());
  };
  if (const auto q = e.numbers("quat", 4, 4); !q.empty()) {
    const Quaternion turn(q[0], q[1], q[2], q[3]);
    if (turn.norm() < 1e-10) e.refuse("quat", "quat is zero, expected a rotation");
    return rotation_matrix(turn / turn.norm());
  }
  if (const auto a = e.numbers("axisangle", 4, 4); !a.empty())
    return rotation_about(unit("axisangle", Vector3d(a[0], a[1], a[2])), angle(a[3]));
  if (const auto a = e.numbers("euler", 3, 3); !a.empty()) return from_euler({a[0], a[1], a[2]});
  if (const auto a = e.numbers("xyaxes", 6, 6); !a.empty()) {
    Matrix3d R;
    R.col(0) = unit("xyaxes", Vector3d(a[0], a[1], a[2]));
    const Vector3d y(a[3], a[4], a[5]);
    R.col(1) = unit("xyaxes", y - y.dot(R.col(0)) * R.col(0));
    R.col(2) = R.col(0).cross(R.col(1));
    return R;
  }
  if (e.has("zaxis")) return turn_from_z(unit("zaxis", e.vector("zaxis", Vector3d::UnitZ())));
  return Matrix3d::Identity();
}

Matrix3d turn_from_z(const Vector3d& direction) {
  const Vector3d d = direction.normalized();
  const Vector3d axis = Vector3d::UnitZ().cross(d);
  const double sine = axis.norm();
  return rotation_about(sine < 1e-10 ? Vector3d::UnitX() : Vector3d(axis / sine), std::atan2(sine, d.z()));
}

}  // namespace borelli
