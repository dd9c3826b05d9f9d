#include "segmentation/labelling/part_findings.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "segmentation/files/plausibility.hpp"
#include "segmentation/labelling/body_doubts.hpp"
#include "segmentation/labelling/edge_contact.hpp"
#include "segmentation/labelling/skin_contact.hpp"
#include "segmentation/labelling/unparted_limbs.hpp"
#include "segmentation/vocabulary/part_words.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Area of the interface between each two parts, mm^2. Exact for a plane of any orientation.
class Sections {
 public:
  Sections(const LabelMap& labels, int threads) {
    const Grid& g = labels.grid;
    const Vector3d edge = g.spacing();
    const Vector3d face(edge[1] * edge[2], edge[2] * edge[0], edge[0] * edge[1]);
    std::mutex mutex;
    in_slabs(g.size[2], threads, [&](std::int64_t first, std::int64_t last) {
      Faces faces{};
      const auto count = [&](std::uint8_t a, std::uint8_t b, std::size_t axis) {
        if (a != b) ++faces[std::min(a, b)][std::max(a, b)][axis];
      };
      for (std::int64_t k = first; k < last; ++k)
        for (std::int64_t j = 0; j < g.size[1]; ++j)
          for (std::int64_t i = 0; i < g.size[0]; ++i) {
            const std::uint8_t here = labels.at(i, j, k);
            if (i + 1 < g.size[0]) count(here, labels.at(i + 1, j, k), 0);
            if (j + 1 < g.size[1]) count(here, labels.at(i, j + 1, k), 1);
            if (k + 1 < g.size[2]) count(here, labels.at(i, j, k + 1), 2);
          }
      const std::lock_guard lock(mutex);
      for (std::size_t a = 0; a < parts.size(); ++a)
        for (std::size_t b = a; b < parts.size(); ++b)
          for (std::size_t axis = 0; axis < 3; ++axis)
            area_[a][b][static_cast<Eigen::Index>(axis)] +=
                static_cast<double>(faces[a][b][axis]) * face[static_cast<Eigen::Index>(axis)];
    });
  }
  double between(std::size_t a, std::size_t b) const { return area_[std::min(a, b)][std::max(a, b)].norm(); }

 private:
  using Faces = std::array<std::array<std::array<std::int64_t, 3>, parts.size()>, parts.size()>;
  std::array<std::array<Vector3d, parts.size()>, parts.size()> area_ = [] {
    std::array<std::array<Vector3d, parts.size()>, parts.size()> none;
    for (auto& row : none) row.fill(Vector3d::Zero());
    return none;
  }();
};

Vector3d point_of(const Grid& g, const std::array<std::int64_t, 3>& place) {
  return g.point(
      Vector3d(static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])));
}

using Contact = std::array<double, 256>;  // see edge_contact

void judge(const Anatomy& a, const Contact& contact, const PartPlanes& planes, const AbsentParts& gone,
           Segmentation& out) {
  std::array<std::int64_t, parts.size()> count{};
  for (const auto label : out.labels.voxels) ++count[label];
  std::optional<Sections> sections;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartFinding& finding = out.part[n];
    finding.volume = static_cast<double>(count[n]) * out.labels.grid.voxel_volume();
    if (count[n] == 0) continue;
    finding.coverage = contact[n] > cut_section ? Coverage::cut : Coverage::whole;
    if (finding.coverage == Coverage::cut) finding.note = "reaches the edge of the scan";
    finding.confidence = 1;
    for (const Part& other : parts) {
      if (other.joint.empty() || (other.name != parts[n].name && other.parent != parts[n].name)) continue;
      const std::string joint(other.joint);
      const bool spine = joint.starts_with("spine");
      const auto neighbour =
          static_cast<std::size_t>(part_label(other.name == parts[n].name ? other.parent : other.name));
      if (gone[neighbour]) continue;
      const std::string bound = bound_of(joint, planes.convention());
      const auto it = out.landmarks.find(bound);
      if (it != out.landmarks.end()) {
        const double deviation = it->second.deviation;
        finding.confidence = std::min(finding.confidence, std::exp(-deviation / 30));
        // the same deviation is a larger share of a cut part
        constexpr double small = 4;  // mm
        if (finding.coverage == Coverage::cut && deviation > small) {
          if (!sections) sections.emplace(out.labels, a.threads);
          finding.confidence =
              std::min(finding.confidence,
                       std::exp(-2 * deviation * sections->between(n, neighbour) / finding.volume));
        }
        const std::size_t said = finding.note.size();
        if (it->second.source.starts_with("proportion"))
          finding.say(in_words(spine ? bound : joint) + " placed by proportion");
        if (it->second.source.ends_with(unlike_other_side))
          finding.say(bound.starts_with("asis")
                          ? "the iliac spines that define its cut are not mirror images of each other"
                          : in_words(bound) + " does not match the other side's");
        if (it->second.source.ends_with(unlike_body))
          finding.say(in_words(bound) + " does not fit the body's size");
        if (const auto own = out.landmarks.find(joint);
            own != out.landmarks.end() && own->second.source.starts_with("regression"))
          finding.say(in_words(joint) + " placed by regression");
        if (finding.note.size() == said && std::exp(-deviation / 30) < least_confidence)
          finding.say(fmt::format("{} may lie {:.0f} mm off", in_words(bound), deviation));
        // the forearm's direction beyond an elbow out of view is unknown
        if (joint.starts_with("elbow") && it->second.source.starts_with("proportion"))
          finding.confidence = std::min(finding.confidence, 0.4);
      } else if (finding.coverage == Coverage::whole || count[neighbour] > 0) {
        finding.doubt(finding.coverage == Coverage::whole ? 0.2 : 0.4,
                      std::string("no cut plane at the ") + in_words(joint));
      }
    }
  }
}

// Landmarks of a hand or foot, its joint first, then its ends.
constexpr std::array<std::array<std::string_view, 4>, 2> ends{
    {{"hand", "wrist", "metacarpale_3", "dactylion_3"}, {"foot", "ankle", "heel", "toe_tip"}}};

// Raises the deviations of the joint and ends of a hand or foot that is incomplete or holds more than itself:
// they may be off by its size. `size`: edge of a cube of the expected volume, mm.
void doubt_ends(std::string_view part, double size, Landmarks& marks) {
  constexpr std::array<double, 4> share{0, 0.5, 1, 2};  // of `size`; a hand or foot is about 2.5 long
  for (const auto& end : ends) {
    if (!part.starts_with(end[0])) continue;
    for (std::size_t n = 1; n < end.size(); ++n) {
      const auto mark = marks.find(std::string(end[n]) + std::string(part.substr(end[0].size())));
      if (mark != marks.end()) mark->second.deviation = std::max(mark->second.deviation, share[n] * size);
    }
  }
}

// Removes the end landmarks of hands and feet that the scan cuts, and a foot's metatarsals, which follow from
// its length.
void forget_cut_ends(Segmentation& out) {
  for (std::size_t n = 1; n < parts.size(); ++n)
    for (const auto& end : ends)
      if (parts[n].name.starts_with(end[0]) && out.part[n].coverage == Coverage::cut)
        for (const auto& name : {end[2], end[3]})
          out.landmarks.erase(std::string(name) + std::string(parts[n].name.substr(end[0].size())));
  for (const char* side : {"_left", "_right"})
    if (out.part[static_cast<std::size_t>(part_label(std::string("foot") + side))].coverage == Coverage::cut)
      for (const char* name : {"metatarsal_1", "metatarsal_2", "metatarsal_5"})
        out.landmarks.erase(std::string(name) + side);
}

struct Tip {
  std::string_view part, before, joint;
  int own = part_label(part), nearer = part_label(before);
  std::vector<std::array<std::int64_t, 3>> places{};
};

// Hands and feet, each with its voxels.
std::array<Tip, 4> find_tips(const Anatomy& a, const Volume<std::uint8_t>& owner, const PartPlanes& planes) {
  std::array<Tip, 4> tips{{{"hand_left", "forearm_left", "wrist_left"},
                           {"hand_right", "forearm_right", "wrist_right"},
                           {"foot_left", "shank_left", "ankle_left"},
                           {"foot_right", "shank_right", "ankle_right"}}};
  const auto& g = a.grid();
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const auto own = owner.at(i, j, k);
        if (!own || !a.body.at(i, j, k)) continue;
        for (Tip& tip : tips) {
          if ((own == tip.own || own == tip.nearer) && planes.part(own, point_of(g, {i, j, k})) == tip.own)
            tip.places.push_back({i, j, k});
        }
      }
  return tips;
}

// Marks hands and feet whose fingers or toes the scan's end cuts. They are too slender for the depth test.
void note_cut_tips(const Anatomy& a, const std::array<Tip, 4>& tips, Segmentation& out) {
  const auto point = [&](const std::array<std::int64_t, 3>& place) { return point_of(a.grid(), place); };
  for (const Tip& tip : tips) {
    PartFinding& finding = out.part[static_cast<std::size_t>(part_label(tip.part))];
    const auto joint = out.landmarks.find(std::string(tip.joint));
    if (finding.coverage != Coverage::whole || joint == out.landmarks.end() || tip.places.empty()) continue;
    Vector3d mean = Vector3d::Zero();
    for (const auto& place : tip.places) mean += point(place);
    mean /= static_cast<double>(tip.places.size());
    // a foot points along its longest axis; a hand cut in its palm would be longest across
    Vector3d outwards = mean - joint->second.point;
    if (tip.part.starts_with("foot")) {
      Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
      for (const auto& place : tip.places)
        spread += (point(place) - mean) * (point(place) - mean).transpose();
      const Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
      outwards = outwards.dot(axis) < 0 ? Vector3d(-axis) : axis;
    }
    if (!runs_out(tip.places, a.scan.seen, outwards.normalized())) continue;
    finding.coverage = Coverage::cut;
    finding.note = "reaches the edge of the scan" + (finding.note.empty() ? "" : "; " + finding.note);
  }
}

// Last check: a whole part with an impossible share of the other whole parts is incomplete or holds more than
// itself. From children to the very heavy, a part's mass share is within a factor of two of an adult's.
void doubt_impossible_shares(Segmentation& out) {
  constexpr double most = 2.8;
  // total body volume implied by each part
  std::array<double, parts.size()> body{};
  std::vector<double> whole;
  double trunk = 0, trunk_share = 0;  // with `bone` its parts have other bounds; only their sum compares
  bool trunk_is_whole = out.convention == Convention::bone;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const bool of_trunk = out.convention == Convention::bone && parts[n].name.ends_with("_trunk");
    if (out.part[n].coverage != Coverage::whole) {
      trunk_is_whole = trunk_is_whole && !of_trunk;
      continue;
    }
    const double share = share_of_mass(parts[n].name);
    if (of_trunk)
      trunk += out.part[n].volume, trunk_share += share;
    else
      body[n] = out.part[n].volume / share;
    if (!of_trunk) whole.push_back(body[n]);
  }
  if (trunk_is_whole) {
    whole.push_back(trunk / trunk_share);
    for (const char* name : {"upper_trunk", "middle_trunk", "lower_trunk"})
      body[static_cast<std::size_t>(part_label(name))] = whole.back();
  }
  if (whole.size() < 3) return;
  const auto middle = whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2);
  std::nth_element(whole.begin(), middle, whole.end());
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (body[n] == 0 || (body[n] < most * *middle && body[n] > *middle / most)) continue;
    PartFinding& finding = out.part[n];
    finding.coverage = Coverage::cut;
    finding.confidence = std::min(finding.confidence, 0.1);
    finding.note =
        std::string(body[n] > *middle
                        ? "it is too large, compared with the other whole parts, to be this part alone"
                        : "it is too small, compared with the other whole parts, to be the whole part") +
        (finding.note.empty() ? "" : "; " + finding.note);
    doubt_ends(parts[n].name, std::cbrt(finding.volume * *middle / body[n]), out.landmarks);
  }
}

// Doubts arms that touch another part: flesh depth divides them, nothing that the scan shows.
void doubt_what_touches(const std::array<double, parts.size()>& area, Segmentation& out) {
  constexpr double much = 0.15;  // fraction of the face area of a cube of the part's volume
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartFinding& finding = out.part[n];
    if (finding.volume == 0 || area[n] < much * std::pow(finding.volume, 2.0 / 3)) continue;
    finding.doubt(0.4, fmt::format("nothing shows its boundary where it touches other parts ({:.0f} cm2)",
                                   area[n] * 1e-2));
  }
}

}  // namespace

std::string_view name_of(Coverage coverage) {
  switch (coverage) {
    case Coverage::absent:
      return "absent";
    case Coverage::cut:
      return "cut";
    case Coverage::whole:
      return "whole";
  }
  return "";
}

void judge_parts(const Anatomy& a, const Volume<std::uint8_t>& owner, const PartPlanes& planes,
                 const AbsentParts& gone, Segmentation& out) {
  // three passes over the work grid, one thread each, in parallel
  auto touched = std::async(aside(a.threads), [&] { return contact_areas(a, owner, planes); });
  auto tips = std::async(aside(a.threads), [&] { return find_tips(a, owner, planes); });
  judge(a,
        edge_contact(a.body, a.scan.seen, a.depth, owner,
                     [&](std::uint8_t own, const Vector3d& point) { return planes.part(own, point); }),
        planes, gone, out);
  note_cut_tips(a, tips.get(), out);
  forget_cut_ends(out);
  note_stumps(out);
  note_missing_cuts(planes, out);
  doubt_unparted_limbs(out);
  doubt_jointless_limbs(a, out);
  doubt_impossible_shares(out);
  doubt_what_touches(touched.get(), out);
}

void warn_of_lone_limbs(const Trunk& trunk, Segmentation& out) {
  for (const int side : {left_side, right_side})
    for (const auto& [gone, root, limb] :
         {std::tuple{trunk.no_leg, "thigh", "leg"}, {trunk.no_arm, "upper_arm", "arm"}}) {
      const std::string at = side_suffix(side);
      if (!gone[static_cast<std::size_t>(side)] || is_absent(out.absent, root, at)) continue;
      out.warnings.push_back(
          {WarningKind::body, Severity::doubt,
           fmt::format("the scan shows no {0} {1}; if the body lacks it, give --absent {2}{3}", at.substr(1),
                       limb, root, at)});
    }
}

void doubt_hands_that_meet(Segmentation& out) {
  constexpr double alike = 1.3;  // largest volume ratio of a body's hands
  PartFinding &left = out.part[static_cast<std::size_t>(part_label("hand_left"))],
              &right = out.part[static_cast<std::size_t>(part_label("hand_right"))];
  PartFinding &larger = left.volume > right.volume ? left : right,
              &smaller = left.volume > right.volume ? right : left;
  if (larger.volume < alike * smaller.volume || smaller.coverage == Coverage::absent ||
      larger.coverage != Coverage::whole)
    return;
  for (PartFinding* hand : {&larger, &smaller}) {
    hand->coverage = Coverage::cut;
    hand->doubt(0.1, std::string(hand == &larger ? "may include" : "may lack") +
                         " part of a hand: the bones of the arms touch, and the hands differ in volume");
  }
  forget_cut_ends(out);
}

void doubt_what_holds_arms(const Anatomy& a, const Volume<std::uint8_t>& owner, const PartPlanes& planes,
                           double hips, Segmentation& out) {
  constexpr double thin = 600, much = 5e4, share = 0.02;  // mm^2 of a slice; mm^3; of a part
  constexpr double above = 60, at_thighs = 100;           // mm above the hips
  const auto& g = a.grid();
  Mask slice{g, {}};
  slice.grid.size[2] = 1;
  std::array<double, parts.size()> beside{};
  double all = 0, lowest = std::numeric_limits<double>::infinity();
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    const double z = g.point(Vector3d(0, 0, static_cast<double>(k)))[2];
    if (z < hips + above) continue;
    const auto first = a.body.voxels.begin() + static_cast<std::ptrdiff_t>(g.offset(0, 0, k));
    slice.voxels.assign(first, first + static_cast<std::ptrdiff_t>(slice.grid.count()));
    // the slice's pieces; all but the largest lie beside the trunk
    const Regions pieces = connected_regions(slice, 6, 1);
    const auto is_arm = [&](std::int32_t number) {
      if (number <= 1) return false;
      const auto voxels = pieces.list[static_cast<std::size_t>(number - 1)].voxels;
      return static_cast<double>(voxels) * a.step() * a.step() >= thin;
    };
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!is_arm(pieces.number.at(i, j, 0))) continue;
        const auto own = owner.at(i, j, k);
        const int part = own ? planes.part(own, g.point(i, j, k)) : 0;
        if (part >= part_label("upper_arm_left") && part <= part_label("hand_right"))
          continue;  // (forest_parts)
        lowest = std::min(lowest, z);
        if (!part) continue;
        beside[static_cast<std::size_t>(part)] += g.voxel_volume();
        all += g.voxel_volume();
      }
  }
  if (all < much) return;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    PartFinding& finding = out.part[n];
    const bool by_hands = parts[n].name.starts_with("thigh") && lowest < hips + at_thighs;
    if (finding.volume == 0 || (beside[n] < share * finding.volume && !by_hands)) continue;
    finding.coverage = Coverage::cut;
    finding.doubt(0.2, "may include flesh of the arms, whose shoulders are not in view");
  }
}

void doubt_thighs_above_crotch(const Anatomy& a, const Volume<std::uint8_t>& owner, Segmentation& out) {
  const auto& g = a.grid();
  const auto slice = static_cast<std::size_t>(g.size[0] * g.size[1]);
  const auto last = std::find(a.body.voxels.rbegin(), a.body.voxels.rend(), 1);
  if (last == a.body.voxels.rend()) return;
  const std::size_t first = static_cast<std::size_t>(a.body.voxels.rend() - last - 1) / slice * slice;
  Mask top{g,
           {a.body.voxels.begin() + static_cast<std::ptrdiff_t>(first),
            a.body.voxels.begin() + static_cast<std::ptrdiff_t>(first + slice)}};
  top.grid.size[2] = 1;
  const Regions pieces = connected_regions(top, 6);
  constexpr int left = part_label("thigh_left"), right = part_label("thigh_right");
  std::vector<std::array<bool, 2>> holds(pieces.list.size(), {false, false});
  for (std::size_t o = 0; o < slice; ++o)
    if (const auto number = pieces.number.voxels[o]) {
      auto& here = holds[static_cast<std::size_t>(number - 1)];
      here[0] = here[0] || owner.voxels[first + o] == left;
      here[1] = here[1] || owner.voxels[first + o] == right;
    }
  if (std::none_of(holds.begin(), holds.end(), [](const auto& both) { return both[0] && both[1]; })) return;
  for (const int label : {left, right})
    out.part[static_cast<std::size_t>(label)].doubt(
        0.4, "may include flesh of the lower trunk, whose hips are not in view");
}

void doubt_trunk_without_shoulders(Segmentation& out) {
  PartFinding& trunk = out.part[static_cast<std::size_t>(part_label("upper_trunk"))];
  if (trunk.volume == 0) return;
  trunk.coverage = Coverage::cut;
  trunk.doubt(0.2, "includes the visible part of the shoulders and arms");
}

void doubt_trunk_without_hips(const Anatomy& a, const Volume<std::uint8_t>& owner, const PartPlanes& planes,
                              double scale, Segmentation& out) {
  constexpr int lower = part_label("lower_trunk");
  constexpr double below = 45;  // mm below the omphalion: flanks end, thighs begin laterally
  PartFinding& finding = out.part[static_cast<std::size_t>(lower)];
  const auto omphalion = out.landmarks.find("omphalion");
  if (finding.volume == 0 || omphalion == out.landmarks.end() || planes.parts_off(part_label("thigh_left")) ||
      planes.parts_off(part_label("thigh_right")))
    return;
  const auto first = std::find(owner.voxels.begin(), owner.voxels.end(), lower) - owner.voxels.begin();
  const auto slice = static_cast<std::ptrdiff_t>(owner.grid.size[0] * owner.grid.size[1]);
  const double low = a.grid().point(Vector3d(0, 0, static_cast<double>(first / slice)))[2];
  if (low > omphalion->second.point[2] - below * scale) return;
  finding.doubt(0.4, "may include flesh of the thighs, whose hips are not in view");
}

void warn_of_flesh_without_part(const Anatomy& a, const Volume<std::uint8_t>& owner, Segmentation& out) {
  constexpr double much = 0.1e6, share = 0.01;  // mm^3; of the body in view
  double body = 0, without = 0;
  for (std::size_t o = 0; o < owner.voxels.size(); ++o)
    if (a.body.voxels[o]) ++body, without += owner.voxels[o] == 0;
  const double voxel = a.grid().voxel_volume();
  if (without * voxel > much && without > share * body)
    out.warnings.push_back({WarningKind::body, Severity::doubt,
                            fmt::format("{:.1f} of the {:.1f} l of visible body belong to no part and are "
                                        "left out; a limb is found only if its hip or shoulder is in view",
                                        1e-6 * without * voxel, 1e-6 * body * voxel)});
}

}  // namespace borelli
