#include "pipeline/motion/angle_motion.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>

#include "dynamics/numbers/rotation_between.hpp"
#include "error/printable.hpp"
#include "pipeline/body/joint_axes.hpp"
#include "pipeline/body/segment_frames.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/solid_poses.hpp"
#include "pipeline/recordings/text_rows.hpp"

namespace borelli {
namespace data {
extern const char* const coordinate_names;
}  // namespace data

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double flat_foot = 0.02;  // m: a foot is flat if the heights of its sole points differ by less

/// A row of data/coordinate_names.csv, of one side.
struct NamedCoordinate {
  std::string joint;  ///< "pelvis": the root
  char axis = '1';
  double sign = 1;  ///< 0: by the data
  std::string name;
};

std::vector<NamedCoordinate> read_coordinate_names() {
  std::vector<NamedCoordinate> out;
  std::istringstream lines(data::coordinate_names);
  bool heading = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#' || std::exchange(heading, false)) continue;
    std::istringstream cells(line);
    std::string joint, axis, sign, name;
    std::getline(cells, joint, ','), std::getline(cells, axis, ','), std::getline(cells, sign, ',');
    std::getline(cells, name);
    if (!joint.ends_with('*')) {
      out.push_back({joint, axis[0], std::stod(sign), name});
      continue;
    }
    joint.pop_back();
    for (const char* side : {"_right", "_left"})
      out.push_back({joint + side, axis[0], std::stod(sign), name + std::string(side).substr(0, 2)});
  }
  return out;
}

const std::vector<NamedCoordinate>& coordinate_names() {
  static const std::vector<NamedCoordinate> names = read_coordinate_names();
  return names;
}

/// The free body that carries the others, and where its coordinates are.
struct Root {
  std::string solid;
  Eigen::Index place = -1, turn = -1;  ///< of three translations and a ball's quaternion in q
};

Root root_of(const System& system) {
  Root out;
  for (const CoordinateInfo& c : system.coordinates) {
    const auto solid = std::size_t(solid_index(system, c.solid));
    if (system.bodies[std::size_t(system.solid_bodies[solid])].parent != 0) continue;
    if (!out.solid.empty() && c.solid != out.solid) continue;
    if (!c.solid.ends_with("trunk")) continue;
    out.solid = c.solid;
    if (c.kind == "translation" && out.place < 0) out.place = c.q_index;
    if (c.kind == "ball") out.turn = c.q_index;
  }
  return out.place >= 0 && out.turn >= 0 ? out : Root{};
}

const CoordinateInfo* coordinate_named(const System& system, const std::string& name) {
  const auto found = std::ranges::find(system.coordinates, name, &CoordinateInfo::name);
  return found == system.coordinates.end() ? nullptr : &*found;
}

bool names_own(const System& system, const MotionTable& table) {
  return std::ranges::any_of(system.coordinates, [&](const CoordinateInfo& c) {
    return coordinate_column(table, c.q_size == 4 ? c.name + ".w" : c.name) >= 0;
  });
}

/// Gives each ball's quaternion the sign that is nearer to the one before: q and -q are the same turn.
void make_continuous(const System& system, Rows& q) {
  for (const CoordinateInfo& c : system.coordinates)
    for (Eigen::Index i = 1; c.q_size == 4 && i < q.rows(); ++i)
      if (q.row(i).segment<4>(c.q_index).dot(q.row(i - 1).segment<4>(c.q_index)) < 0)
        q.row(i).segment<4>(c.q_index) *= -1;
}

/// OpenSim's ground in the world: its y becomes z.
Matrix3d ground_axes() { return rotation_between(Vector3d::UnitY(), Vector3d::UnitZ()); }

/// The joints of a body by OpenSim's coordinates.
class OpenSimAngles {
 public:
  OpenSimAngles(const System& system, const Landmarks& landmarks, const MotionTable& table)
      : system_(system), table_(table), root_(root_of(system)) {
    find_columns();
    out_.root = root_.solid;
    if (!root_.solid.empty()) place_root(landmarks);
  }

  Result<AngleMotion> read() {
    if (used_.empty())
      return bad_use("motion",
                     fmt::format("has no column for any joint of the body; expected its own coordinates or "
                                 "OpenSim's (hip_flexion_r, knee_angle_r, pelvis_tilt ...)"));
    const auto count = std::ssize(table_.times);
    out_.positions.times = table_.times;
    out_.positions.q = system_.initial.q.transpose().replicate(count, 1);
    for (Eigen::Index i = 0; i < count; ++i) {
      for (const auto& [name, found] : used_)
        if (!std::isfinite(table_.values(i, found.column)))
          return bad_use("motion", fmt::format("has a value of '{}' at {} s that is not a number",
                                               printable(name), table_.times[std::size_t(i)]));
      for (const CoordinateInfo& c : system_.coordinates) set_joint(c, i);
      if (!root_.solid.empty()) set_root(i);
    }
    make_continuous(system_, out_.positions.q);
    tell();
    return std::move(out_);
  }

 private:
  struct Column {
    Eigen::Index column = -1;
    double factor = 1;  ///< to rad or m along the axis
    char axis = '1';
    std::string joint;
  };

  void find_columns() {
    for (const NamedCoordinate& named : coordinate_names()) {
      const Eigen::Index column = coordinate_column(table_, named.name);
      const bool has =
          named.joint == "pelvis" ? !root_.solid.empty() : coordinate_named(system_, named.joint) != nullptr;
      if (column < 0 || !has) continue;
      double factor = named.sign;
      if (factor == 0)
        factor = table_.values.col(column).maxCoeff() >= -table_.values.col(column).minCoeff() ? 1 : -1;
      const bool turns = named.axis <= '3';
      if (turns && table_.in_degrees) factor *= std::numbers::pi / 180;
      used_.emplace_back(named.name, Column{column, factor, named.axis, named.joint});
    }
  }

  /// The turn of a joint in its axes, in the order of the table's rows.
  Matrix3d turn_of(const std::string& joint, Eigen::Index row) const {
    Matrix3d R = Matrix3d::Identity();
    for (const auto& [name, found] : used_)
      if (found.joint == joint && found.axis <= '3')
        R *= Eigen::AngleAxisd(found.factor * table_.values(row, found.column),
                               Vector3d::Unit(found.axis - '1'))
                 .toRotationMatrix();
    return R;
  }

  void set_joint(const CoordinateInfo& c, Eigen::Index row) {
    const auto solid = std::size_t(solid_index(system_, c.solid));
    if (!c.angle || system_.bodies[std::size_t(system_.solid_bodies[solid])].parent == 0) return;
    auto q = out_.positions.q.row(row);
    if (c.q_size == 4) {
      q.segment<4>(c.q_index) = quaternion(turn_of(c.name, row)).transpose();
      return;
    }
    q[c.q_index] = 0;
    for (const auto& [name, found] : used_)
      if (found.joint == c.name) q[c.q_index] = found.factor * table_.values(row, found.column);
  }

  void set_root(Eigen::Index row) {
    // tilt, list and rotation are about z, x and y of the pelvis
    Matrix3d R_FA;
    R_FA << Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY();
    const Matrix3d R_WF = ground_axes() * R_FA * turn_of("pelvis", row) * R_FA.transpose();
    const Matrix3d R_WS = R_WF * R_SF_.transpose();
    Vector3d place = Vector3d::Zero();
    for (const auto& [name, found] : used_)
      if (found.joint == "pelvis" && found.axis > '3')
        place[found.axis - 'x'] = found.factor * table_.values(row, found.column);
    auto q = out_.positions.q.row(row);
    q.segment<3>(root_.place) = (ground_axes() * place - R_WS * out_.root_point).transpose();
    q.segment<4>(root_.turn) = quaternion(R_WS).transpose();
  }

  /// In the scan's pose a solid's axes are the patient's.
  void place_root(const Landmarks& landmarks) {
    if (const auto frame = segment_frame(root_.solid, landmarks, {})) R_SF_ = frame->R_WA;
    const auto left = landmarks.find("asis_left"), right = landmarks.find("asis_right");
    if (left == landmarks.end() || right == landmarks.end()) {
      out_.warnings.emplace_back(
          "the body lacks an ASIS, so the middle of its hips follows the pelvis's path");
      return;
    }
    SolidPoses poses(system_);
    poses.update(0, system_.initial.q);
    const Vector3d middle = 1e-3 * (left->second.point + right->second.point) / 2;
    out_.root_point = poses.of(solid_index(system_, root_.solid)).inverse() * middle;
  }

  void tell() {
    std::vector<std::string> still, unused;
    const auto has_column = [&](const std::string& joint) {
      return std::ranges::any_of(used_, [&](const auto& one) { return one.second.joint == joint; });
    };
    for (const CoordinateInfo& c : system_.coordinates)
      if (c.angle && c.solid != root_.solid && !has_column(c.name)) still.push_back(c.name);
    if (!root_.solid.empty() && !has_column("pelvis")) still.emplace_back("pelvis");
    if (!still.empty())
      out_.warnings.push_back(fmt::format(
          "joints without a column in the motion stay in the anatomical position: {}", name_list(still)));
    for (std::size_t i = 0; i < table_.columns.size(); ++i)
      if (!table_.columns[i].ends_with("/speed") &&
          std::ranges::none_of(used_, [&](const auto& one) { return one.second.column == Eigen::Index(i); }))
        unused.push_back(printable(table_.columns[i]));
    if (!unused.empty())
      out_.warnings.push_back(
          fmt::format("ignored columns, which belong to no joint of this body: {}", name_list(unused)));
  }

  const System& system_;
  const MotionTable& table_;
  Root root_;
  Matrix3d R_SF_ = Matrix3d::Identity();
  std::vector<std::pair<std::string, Column>> used_;
  AngleMotion out_;
};

}  // namespace

Result<AngleMotion> angle_motion(const System& body, const Landmarks& landmarks, const MotionTable& table) {
  if (!names_own(body, table)) return OpenSimAngles(body, landmarks, table).read();
  auto found = positions_in(body, table);
  if (!found) return tl::unexpected(found.error());
  make_continuous(body, found->positions.q);
  return AngleMotion{std::move(found->positions), root_of(body).solid, Vector3d::Zero(),
                     std::move(found->warnings)};
}

double size_by_height(const System& body, const AngleMotion& motion, const FootSoles& soles) {
  if (motion.root.empty()) return 1;
  SolidPoses poses(body);
  poses.update(0, body.initial.q);
  std::map<int, std::vector<Vector3d>> feet;  // points of the sole in each foot
  for (const auto& [foot, points] : soles)
    if (const int solid = solid_index(body, foot); solid >= 0)
      for (const Vector3d& point : points) feet[solid].push_back(poses.of(solid).inverse() * point);
  std::vector<double> flat, all;
  for (Eigen::Index i = 0; i < motion.positions.q.rows() && !feet.empty(); ++i) {
    poses.update(0, motion.positions.q.row(i).transpose());
    double lowest = std::numeric_limits<double>::infinity(), slope = 0;
    for (const auto& [solid, points] : feet) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const Vector3d& point : points) {
        const double z = (poses.of(solid) * point).z();
        low = std::min(low, z), high = std::max(high, z);
      }
      if (low < lowest) lowest = low, slope = high - low;
    }
    const double height = (poses.of(solid_index(body, motion.root)) * motion.root_point).z();
    all.push_back(height / (height - lowest));
    if (slope < flat_foot) flat.push_back(all.back());
  }
  std::vector<double>& sizes = flat.empty() ? all : flat;
  if (sizes.empty()) return 1;
  std::ranges::nth_element(sizes, sizes.begin() + std::ssize(sizes) / 2);
  return sizes[sizes.size() / 2];
}

RecordedPositions at_size(const System& body, const AngleMotion& motion, double size) {
  RecordedPositions out = motion.positions;
  const Root root = root_of(body);
  if (root.solid.empty()) return out;
  for (Eigen::Index i = 0; i < out.q.rows(); ++i) {
    const Quaternion turn = out.q.row(i).segment<4>(root.turn).transpose();
    out.q.row(i).segment<3>(root.place) +=
        (1 - size) * (rotation_matrix(turn) * motion.root_point).transpose();
  }
  return out;
}

}  // namespace borelli
