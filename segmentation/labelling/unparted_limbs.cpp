#include "segmentation/labelling/unparted_limbs.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/limb_lengths.hpp"
#include "segmentation/vocabulary/part_words.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct LimbPart {
  const char *name, *from, *to, *beyond;
};
constexpr std::array<LimbPart, 4> limb_parts{{{"thigh", "hip", "knee", "shank and foot"},
                                              {"shank", "knee", "ankle", "foot"},
                                              {"upper_arm", "shoulder", "elbow", "forearm and hand"},
                                              {"forearm", "elbow", "wrist", "hand"}}};

constexpr const LimbPart* upper_arm = &limb_parts[2];

const Landmark* find(const Landmarks& marks, const std::string& name) {
  const auto it = marks.find(name);
  return it == marks.end() ? nullptr : &it->second;
}

// The longest plausible upper arm for this body, mm, by the distance from hips to shoulders or the shoulders'
// width (de Leva's male: 282 at 515 from hips to shoulders and 364 from shoulder to shoulder). 0: unknown.
double usual_upper_arm(const Landmarks& marks) {
  constexpr double length = 282, tall = 515, broad = 364, longest = 1.15;
  const Landmark *left = find(marks, "shoulder_left"), *right = find(marks, "shoulder_right"),
                 *hips = find(marks, "mid_hip");
  if (!left || !right) return 0;
  const double size = hips ? (0.5 * (left->point + right->point) - hips->point).norm() / tall
                           : (left->point - right->point).norm() / broad;
  return longest * length * size;
}

}  // namespace

void note_stumps(Segmentation& out) {
  for (std::size_t n = 1; n < parts.size(); ++n)
    if (out.absent[n]) out.part[n] = {Coverage::absent, 0, 0, std::string(stated_as_absent)};
  for (std::size_t n = 5; n < parts.size(); ++n) {
    PartFinding& finding = out.part[n];
    if (finding.volume == 0) continue;
    std::string lacks;  // absent parts, outwards from here
    for (std::size_t m = n + 1, last = n; m < parts.size(); ++m) {
      if (!out.absent[m] || parts[m].parent != parts[last].name) continue;
      const std::string_view name = parts[m].name;
      lacks += (lacks.empty() ? "" : " and ") + in_words(name.substr(0, name.rfind('_')));
      last = m;
    }
    if (lacks.empty()) continue;
    finding.coverage = Coverage::cut;
    finding.note = std::string(stump_note) + lacks +
                   (lacks.find(" and ") == std::string::npos ? " is " : " are ") +
                   std::string(stated_as_absent) + (finding.note.empty() ? "" : "; " + finding.note);
  }
}

void note_missing_cuts(const PartPlanes& planes, Segmentation& out) {
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (out.part[n].coverage != Coverage::whole) continue;
    // the following parts of the limb that no plane separates
    std::string included, joint;
    std::size_t last = n;
    for (std::size_t m = 1; m < parts.size(); ++m) {
      const bool limb = parts[m].joint.ends_with("_left") || parts[m].joint.ends_with("_right");
      if (!limb || parts[m].parent != parts[last].name || last < 5 || out.part[m].volume > 0) continue;
      if (out.absent[m]) break;
      if (planes.parts_off(static_cast<int>(m))) break;
      const std::string side = parts[m].name.ends_with("_left") ? "_left" : "_right";
      const auto bare = [&](std::string_view name) {
        return in_words(name.substr(0, name.size() - side.size()));
      };
      if (joint.empty()) joint = bare(parts[m].joint);
      included += (included.empty() ? "" : " and ") + bare(parts[m].name);
      out.part[m].coverage = Coverage::cut;
      out.part[m].say("included in the " + bare(parts[n].name) + ": no " + joint + " was found");
      last = m;
    }
    if (last == n) continue;
    out.part[n].coverage = Coverage::cut;
    out.part[n].confidence = std::min(out.part[n].confidence, 0.2);
    out.part[n].note.clear();  // replaces "no cut plane at the left knee"
    out.part[n].say("no " + joint + " was found: this part includes the " + included);
  }
}

void doubt_unparted_limbs(Segmentation& out) {
  constexpr double share = 0.01, longer = 1.1, thick = 20;  // fraction of a part; ratio of lengths; mm
  const Grid& g = out.labels.grid;
  for (const LimbPart& limb : limb_parts)
    for (const int side : {left_side, right_side}) {
      const std::string own = side_suffix(side), other = side_suffix(1 - side);
      const auto label = static_cast<std::size_t>(part_label(limb.name + own));
      PartFinding& finding = out.part[label];
      const Landmark *from = find(out.landmarks, limb.from + own),
                     *far_from = find(out.landmarks, limb.from + other),
                     *far_to = find(out.landmarks, limb.to + other);
      if (finding.volume == 0 || finding.coverage != Coverage::cut || out.landmarks.contains(limb.to + own))
        continue;
      const double usual = &limb == upper_arm && from ? usual_upper_arm(out.landmarks) : 0;
      const bool compares = far_to && !is_doubted(*far_to);
      if (!compares && usual == 0) continue;
      const bool by_length = !compares || (from && far_from);
      if (!by_length && &limb != &limb_parts[0]) continue;
      const double length = !compares ? usual : by_length ? (far_to->point - far_from->point).norm() : 0;
      const double reach = longer * length + thick;
      double beyond = 0;
      for (std::int64_t k = 0; k < g.size[2]; ++k)
        for (std::int64_t j = 0; j < g.size[1]; ++j)
          for (std::int64_t i = 0; i < g.size[0]; ++i) {
            if (out.labels.at(i, j, k) != label) continue;
            const Vector3d p = g.point(i, j, k);
            if (by_length ? (p - from->point).norm() > reach : p[2] < far_to->point[2])
              beyond += g.voxel_volume();
          }
      if (beyond < share * finding.volume) continue;
      const std::string no_joint = std::string("no ") + limb.to + " was found: this part includes the ";
      if (finding.note.starts_with(stump_note))
        finding.doubt(0.2, std::string("it is longer than the other side's, which has a ") + limb.to);
      else if (finding.note.find(no_joint) == std::string::npos)
        finding.doubt(0.2, no_joint + "visible part of the " + limb.beyond);
    }
}

void doubt_jointless_limbs(const Anatomy& a, Segmentation& out) {
  constexpr double last = 10, near = 15;  // mm: length of an end; from the scan's edge
  const Grid& g = out.labels.grid;
  for (const LimbPart& limb : {limb_parts[1], limb_parts[3]})
    for (const int side : {left_side, right_side}) {
      const std::string own = side_suffix(side);
      const auto label = static_cast<std::size_t>(part_label(limb.name + own)),
                 next = static_cast<std::size_t>(part_label(limb.beyond + own));
      PartFinding& finding = out.part[label];
      if (finding.volume == 0 || finding.coverage != Coverage::cut || out.part[next].volume > 0 ||
          out.absent[next] || find(out.landmarks, limb.from + own) || find(out.landmarks, limb.to + own))
        continue;
      std::vector<Vector3d> points;
      Vector3d middle = Vector3d::Zero();
      for (std::int64_t k = 0; k < g.size[2]; ++k)
        for (std::int64_t j = 0; j < g.size[1]; ++j)
          for (std::int64_t i = 0; i < g.size[0]; ++i)
            if (out.labels.at(i, j, k) == label) points.push_back(g.point(i, j, k)), middle += points.back();
      middle /= static_cast<double>(points.size());
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (const Vector3d& p : points) spread += (p - middle) * (p - middle).transpose();
      const Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
      std::array<bool, 2> at_edge{};
      for (const std::size_t end : {0, 1}) {
        const Vector3d outwards = end == 0 ? axis : Vector3d(-axis);
        double farthest = 0;
        for (const Vector3d& p : points) farthest = std::max(farthest, outwards.dot(p - middle));
        Vector3d sum = Vector3d::Zero();
        double count = 0;
        for (const Vector3d& p : points)
          if (outwards.dot(p - middle) > farthest - last) sum += p, ++count;
        at_edge[end] = a.near_edge(sum / count, near);
      }
      const std::string no_joint = std::string("no ") + limb.to + " was found";
      if (at_edge[0] && at_edge[1])
        finding.doubt(0.4, no_joint + ": this part may include some of the " + limb.beyond);
      if (at_edge[0] == at_edge[1]) continue;
      finding.doubt(0.2, no_joint + ": this part includes the " + limb.beyond);
      out.part[next].coverage = Coverage::cut;
      out.part[next].say("included in the " + in_words(limb.name) + ": " + no_joint);
    }
}

void doubt_head_under_arms(const Anatomy& a, const Limbs& limbs, Segmentation& out) {
  constexpr double below_end = 40, over_shoulder = 40, arm_long = 150;  // mm
  PartFinding& head = out.part[static_cast<std::size_t>(part_label("head"))];
  const double top = a.grid().point(Vector3d(0, 0, static_cast<double>(a.grid().size[2] - 1)))[2];
  for (const int side : {left_side, right_side}) {
    const std::string own = side_suffix(side);
    const LimbPath& path = limbs.arm(side);
    const Landmark* shoulder = find(out.landmarks, "shoulder" + own);
    if (!path.present || !path.cut || !shoulder || out.landmarks.contains("wrist" + own) || head.volume == 0)
      continue;
    const double z = path.points.back()[2];
    if (z > top - below_end || z < shoulder->point[2] + over_shoulder) continue;
    head.doubt(0.2, "may include a hand: a raised arm leaves the scan beside it");
    if (const auto vertex = out.landmarks.find("vertex"); vertex != out.landmarks.end())
      vertex->second.deviation = std::max(vertex->second.deviation, arm_long);
    return;
  }
}

}  // namespace borelli
