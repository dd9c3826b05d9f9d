// skin_ranges LABELS LANDMARKS: how a skin keeps its shape over each joint's range of motion.
//
// Turns one joint of the left side or of the trunk at a time, from the scan's pose, to both ends of its range
// and to half of its upper end (pipeline/data/joint_ranges.csv). Prints the change of the whole volume, the
// area of the cross-section through the joint's centre relative to rest, and the triangles turned inside out.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "pipeline/body/joint_ranges.hpp"
#include "pipeline/export/skin.hpp"
#include "pipeline/export/skin_pose.hpp"
#include "segmentation/files/landmarks_file.hpp"
#include "segmentation/files/read.hpp"

namespace {

using namespace borelli;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Points = std::vector<Vector3d>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;

double volume(const Skin& skin, const Points& p) {
  double six = 0;
  for (const auto& t : skin.mesh.triangles) six += p[t[0]].dot(p[t[1]].cross(p[t[2]]));
  return six / 6;
}

/// The number of triangles turned inside out: the point under the triangle, moved with the corners' mean
/// weights, lies above it.
int flipped(const Skin& skin, const Points& rest, const Points& points, const ScanPoses& X_WS) {
  auto moved = bone_poses(skin, X_WS);
  const auto before = rest_poses(skin);
  for (std::size_t b = 0; b < moved.size(); ++b) moved[b] = moved[b] * before[b].inverse();
  int count = 0;
  for (const auto& t : skin.mesh.triangles) {
    const Vector3d normal = (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]).normalized();
    Vector3d up = Vector3d::Zero();
    for (const auto corner : t)
      for (std::size_t c = 0; c < 4; ++c)
        up += double(skin.weights[corner][c]) * (moved[skin.bones_of[corner][c]].R * normal);
    count += up.dot((points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]])) <= 0;
  }
  return count;
}

/// Area of the cross-section at a joint. The plane through its centre, normal to its axis, cuts the skin at
/// rest in a loop; the area uses the loop's current points.
double section(const Skin& skin, const Points& rest, const Points& now, const SkinPart& part) {
  const auto height = [&](std::uint32_t n) { return part.axis.dot(rest[n] - part.centre); };
  const auto place = [&](const Edge& e, const Points& points) {
    const double a = height(e.first), b = height(e.second);
    return Vector3d(points[e.first] + a / (a - b) * (points[e.second] - points[e.first]));
  };
  std::map<Edge, Edge> next;  // triangles are oriented, so each crossed edge has one next edge
  for (const auto& t : skin.mesh.triangles) {
    Edge in{}, out{};
    int crossed = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[(e + 1) % 3];
      if ((height(a) > 0) == (height(b) > 0)) continue;
      (height(a) > 0 ? in : out) = std::minmax(a, b);
      ++crossed;
    }
    if (crossed == 2) next[in] = out;
  }
  double nearest = 1e30, area = 0;
  while (!next.empty()) {
    Vector3d twice = Vector3d::Zero(), sum = Vector3d::Zero();
    int count = 0;
    for (auto at = next.begin(); at != next.end(); ++count) {
      const auto [from, to] = *at;
      twice += (place(from, now) - part.centre).cross(place(to, now) - part.centre);
      sum += place(from, rest);
      next.erase(at);
      at = next.find(to);
    }
    if (const double away = (sum / count - part.centre).norm(); away < nearest)
      nearest = away, area = twice.norm() / 2;
  }
  return area;
}

/// The joint of joint_ranges.csv that moves a part; "" for none of the left side or trunk.
std::string joint_of(const std::string& part) {
  static const std::map<std::string, std::string> joints{
      {"thigh_left", "hip"},           {"shank_left", "knee"},         {"foot_left", "ankle"},
      {"upper_arm_left", "shoulder"},  {"forearm_left", "elbow"},      {"hand_left", "wrist"},
      {"middle_trunk", "spine_lower"}, {"upper_trunk", "spine_upper"}, {"head", "neck"}};
  const auto found = joints.find(part);
  return found == joints.end() ? "" : found->second;
}

/// A turn of a joint about an axis of the standing body: x left, y posterior, z up.
Matrix3d turn(const SkinPart& part, const std::string& joint, const std::string& motion, double angle) {
  const bool forwards_up = joint != "knee" && joint != "neck" && !joint.starts_with("spine");
  if (motion == "flexion")
    return Eigen::AngleAxisd(forwards_up ? -angle : angle, Vector3d::UnitX()).toRotationMatrix();
  if (motion == "rotation" || motion == "pronation")
    return Eigen::AngleAxisd(angle, part.axis).toRotationMatrix();
  return Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix();
}

/// Poses of all parts when one part, with those beyond it, has turned about its joint.
ScanPoses turned(const Skin& skin, const SkinPart& part, const Matrix3d& R) {
  std::vector<Pose> moved;
  ScanPoses out;
  for (const SkinPart& each : skin.parts) {
    Pose X = each.parent < 0 ? Pose{} : moved[static_cast<std::size_t>(each.parent)];
    if (each.name == part.name) X = X * Pose{R, part.centre - R * part.centre};
    moved.push_back(X);
    out[each.name] = X * each.X_WS;
  }
  return out;
}

void print_ranges(const Skin& skin) {
  Points rest;
  for (const auto& p : skin.mesh.points) rest.push_back(p.cast<double>());
  fmt::print("{:<24} {:>7} {:>9} {:>8} {:>8}\n", "motion", "degrees", "volume %", "section", "flipped");
  int all = 0;
  for (const SkinPart& part : skin.parts) {
    const std::string joint = joint_of(part.name);
    if (joint.empty() || !part.has_joint) continue;
    for (const auto& [name, range] : joint_ranges()) {
      if (!name.starts_with(joint + " ")) continue;
      for (const double angle : {range.lower, range.upper / 2, range.upper}) {
        if (angle == 0) continue;
        const ScanPoses X_WS = turned(skin, part, turn(part, joint, name.substr(joint.size() + 1), angle));
        const Points now = deformed(skin, X_WS);
        const int inside_out = flipped(skin, rest, now, X_WS);
        all += inside_out;
        fmt::print("{:<24} {:>7.0f} {:>+9.2f} {:>8.3f} {:>8}\n", name, angle * 180 / std::numbers::pi,
                   100 * (volume(skin, now) / volume(skin, rest) - 1),
                   section(skin, rest, now, part) / section(skin, rest, rest, part), inside_out);
      }
    }
  }
  fmt::print("{} triangles; {} flipped over all motions\n", skin.mesh.triangles.size(), all);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: skin_ranges LABELS LANDMARKS\n");
    return 2;
  }
  const auto labels = read_labels(argv[1]);
  const auto landmarks = read_landmarks(argv[2]);
  if (!labels || !landmarks) {
    fmt::print(stderr, "{}\n", (labels ? landmarks.error() : labels.error()).message());
    return 1;
  }
  const auto skin = skin_of(*labels, skin_joints(*labels, *landmarks), {});
  if (!skin) {
    fmt::print(stderr, "{}\n", skin.error().message());
    return 1;
  }
  print_ranges(*skin);
}
