#include "segmentation/labelling/forest_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "segmentation/grid/morphology.hpp"
#include "segmentation/proposal/proposal.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// A piece is taken if its confidence, the expected share of right voxels, is at least:
constexpr double sure_piece = 0.75;         // for any other piece
constexpr double sure_column = 0.6;         // for a trunk that shows the vertebral column
constexpr double sure_beside_trunk = 0.67;  // for a limb, if a trunk was taken
constexpr double sure_shank = 0.7;          // for a leg alone whose side is known

// The xiphion lies 33 (male) and 46 mm (female) below the lower end of the lungs in the ICRP adults, who breathe
// quietly. A deep breath moves that end down by up to 60 mm.
constexpr double lungs_to_xiphion = -20, xiphion_spread = 35;  // mm
// The omphalion lies about a vertebra's height above the iliac crests (L4) in the ICRP adults.
constexpr double crest_to_omphalion = 28, omphalion_spread = 20;  // mm

// Centres and areas of the two largest sections of one leg's bone in a slice, larger first; empty unless there
// are just two, as in a shank.
std::optional<std::pair<Region, Region>> shank_bones(const Mask& slice) {
  const Regions pieces = connected_regions(slice, 6, 1);
  constexpr double least = 18;  // mm^2
  const double area = slice.grid.axes(0, 0) * slice.grid.axes(0, 0);
  std::vector<Region> large;
  for (const Region& piece : pieces.list)
    if (static_cast<double>(piece.voxels) * area >= least) large.push_back(piece);
  if (large.size() != 2) return std::nullopt;
  return std::pair{large[0], large[1]};
}

// The side of a leg by its fibula: thinner than the tibia, and lateral of it. Empty if the piece does not show
// both: radius and ulna are about equally thick.
std::optional<int> side_by_fibula(const Anatomy& a, const Proposal& proposal, std::size_t piece) {
  const auto shank = std::ranges::find(voxel_classes, "shank") - voxel_classes.begin();
  constexpr float core = 2;  // mm below the bones' surface, where tibia and fibula do not touch
  constexpr double thinnest = 0.04, thickest = 0.5;  // the fibula's area over the tibia's
  constexpr double nearest = 12, farthest = 70;      // mm between their centres
  constexpr double forward = 0.5;  // most that the fibula lies in front, per lateral distance
  constexpr int fewest = 5;        // slices
  constexpr double agree = 0.8;    // least share of the slices with two bones
  const Grid& g = a.grid();
  Mask slice{g, {}};
  slice.grid.size[2] = 1;
  int two = 0, left = 0, right = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    slice.voxels.assign(slice.grid.count(), 0);
    bool any = false;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (a.within_bone[g.offset(i, j, k)] <= core) continue;
        const std::size_t place = proposal.place_of(g, i, j, k);
        if (proposal.piece_at[place] != static_cast<std::int16_t>(piece) ||
            proposal.voxel_class[place] != shank)
          continue;
        slice.at(i, j, 0) = 1, any = true;
      }
    if (!any) continue;
    const auto bones = shank_bones(slice);
    if (!bones) continue;
    const Vector3d apart = (bones->second.centre - bones->first.centre) * a.step();
    if (apart.norm() < nearest || apart.norm() > farthest) continue;
    if (apart[1] < -forward * std::abs(apart[0])) continue;  // the patella is in front
    ++two;
    const double ratio = static_cast<double>(bones->second.voxels) / static_cast<double>(bones->first.voxels);
    if (ratio < thinnest || ratio > thickest) continue;
    ++(apart[0] > 0 ? left : right);
  }
  if (std::max(left, right) < fewest || std::max(left, right) < agree * two) return std::nullopt;
  return left > right ? left_side : right_side;
}

// Mean of a mask's first index in one slice; empty if it holds nothing there.
std::optional<double> middle_of(const Mask& mask, std::int64_t k) {
  const Grid& g = mask.grid;
  double sum = 0, count = 0;
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i)
      if (mask.at(i, j, k)) sum += static_cast<double>(i), ++count;
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

Mask mask_of(const Anatomy& a, const Proposal& proposal, std::size_t piece) {
  const Grid& g = a.grid();
  Mask out{g, std::vector<std::uint8_t>(g.count())};
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        out.at(i, j, k) = a.body.at(i, j, k) && proposal.piece_at[proposal.place_of(g, i, j, k)] ==
                                                    static_cast<std::int16_t>(piece);
  return out;
}

// Whether most slices of a piece show bone of a vertebra's size in its middle, and its skin on the left and on the
// right. A thigh has less bone; the middle of half a pelvis is a hip, but the scan cuts its medial side.
bool shows_column(const Anatomy& a, const Mask& piece) {
  constexpr double half = 40, vertebra = 700;  // mm, mm^2
  constexpr double most = 0.5, few_cut = 0.2;  // shares of the slices
  const Grid& g = a.grid();
  double slices = 0, columns = 0, cut = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    const auto middle = middle_of(piece, k);
    if (!middle) continue;
    bool at_side = false;
    double bone = 0;
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        if (!piece.at(i, j, k)) continue;
        for (const std::int64_t n : {i - 1, i + 1})
          at_side = at_side || n < 0 || n >= g.size[0] || !a.scan.seen.at(n, j, k);
        if (a.bone.at(i, j, k) && std::abs(static_cast<double>(i) - *middle) * a.step() < half)
          bone += a.step() * a.step();
      }
    ++slices, columns += bone >= vertebra, cut += at_side;
  }
  return columns > most * slices && cut < few_cut * slices;
}

// By piece: whether it is taken, and its side.
struct Choice {
  bool taken = false;
  int side = -1;
  bool across_trunk = false;  // an arm before or behind the trunk's middle
};

// Mean x of each piece's places, mm.
std::vector<double> middles_of(const Proposal& proposal) {
  std::vector<double> sum(proposal.pieces.size()), count(proposal.pieces.size());
  for (std::size_t o = 0; o < proposal.piece_at.size(); ++o)
    if (proposal.piece_at[o] >= 0) {
      const auto p = static_cast<std::size_t>(proposal.piece_at[o]);
      sum[p] += proposal.grid.point(static_cast<std::int64_t>(o) % proposal.grid.size[0], 0, 0)[0],
          ++count[p];
    }
  for (std::size_t p = 0; p < sum.size(); ++p) sum[p] /= std::max(1.0, count[p]);
  return sum;
}

// The side of a leg whose other side the user names as missing.
std::optional<int> side_by_absent(const AbsentParts& absent) {
  const bool no_left = is_absent(absent, "thigh", "_left"), no_right = is_absent(absent, "thigh", "_right");
  if (no_left == no_right) return std::nullopt;
  return no_left ? right_side : left_side;
}

// Whether a leg ends between knee and ankle. The forest puts the ankle of such a piece 50 mm or more too far up or
// down, since it sees no knee.
bool is_foot(const Proposal& proposal, std::size_t piece) {
  const auto has = [&](std::string_view joint) {
    return std::ranges::any_of(proposal.joints, [&](const ProposedJoint& one) {
      return one.piece == piece && one.name.starts_with(joint);
    });
  };
  return has("ankle") && !has("knee");
}

std::vector<Choice> choose_pieces(const Anatomy& a, const Proposal& proposal, const AbsentParts& absent) {
  // mm: least distance of a limb's middle from the trunk's; half the breadth of a narrow trunk
  constexpr double beside_trunk = 60, half_trunk = 120;
  const auto& pieces = proposal.pieces;
  const auto trunk = std::ranges::find_if(pieces, [&](const BodyPiece& piece) {
    if (piece.region != BodyRegion::trunk) return false;
    return piece.confidence >= sure_piece ||
           (piece.confidence >= sure_column &&
            shows_column(a, mask_of(a, proposal, static_cast<std::size_t>(&piece - pieces.data()))));
  });
  const std::vector<double> middle = middles_of(proposal);
  std::vector<Choice> out;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    const BodyPiece& piece = pieces[p];
    Choice choice{piece.confidence >= sure_piece, piece.side};
    if (!is_limb(piece.region)) {
      choice.taken = choice.taken || (trunk != pieces.end() && &piece == &*trunk);
    } else if (trunk != pieces.end()) {  // flesh of a limb that is not taken would go to the trunk
      const double off = middle[p] - middle[static_cast<std::size_t>(trunk - pieces.begin())];
      if (choice.side < 0 && std::abs(off) > beside_trunk) choice.side = off > 0 ? left_side : right_side;
      choice.taken = choice.side >= 0 && piece.confidence >= sure_beside_trunk;
      choice.across_trunk = piece.region == BodyRegion::arm && std::abs(off) < half_trunk;
    } else if (piece.region == BodyRegion::leg) {
      auto side = side_by_absent(absent);
      if (!side && piece.confidence >= sure_shank) side = side_by_fibula(a, proposal, p);
      if (side) choice = {piece.confidence >= sure_shank, *side};
      const bool pair = choice.side >= 0 && proposal.piece(piece.region, 1 - choice.side);
      choice.taken = choice.taken && !is_foot(proposal, p) && (side || pair);
    } else {
      choice.taken = false;
    }
    out.push_back(choice);
  }
  return out;
}

int label_of(std::size_t voxel_class, int side) {
  if (voxel_class == 0) return part_label("head");
  return part_label(std::string(voxel_classes[voxel_class]) + side_suffix(side));
}

// What a slice of the trunk shows beside the column.
struct Flanks {
  bool seen = false;
  std::array<double, 2> bone{};    // mm^2, left and right
  std::array<double, 2> extent{};  // mm, of the longest connected section
};

Flanks flanks_at(const Anatomy& a, const Mask& trunk, std::int64_t k) {
  constexpr double beside = 50;  // mm from the trunk's middle
  const Grid& g = a.grid();
  Flanks out;
  const auto middle = middle_of(trunk, k);
  if (!middle) return out;
  out.seen = true;
  Mask bone{g, {}};
  bone.grid.size[2] = 1;
  bone.voxels.assign(bone.grid.count(), 0);
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i)
      bone.at(i, j, 0) = trunk.at(i, j, k) && a.bone.at(i, j, k) &&
                         std::abs(static_cast<double>(i) - *middle) * a.step() > beside;
  const double area = a.step() * a.step();
  const Regions pieces = connected_regions(bone, 26, 1);
  for (const Region& piece : pieces.list) {
    const std::size_t side = piece.centre[0] > *middle ? 0 : 1;
    out.bone[side] += area * static_cast<double>(piece.voxels);
    const double dx = static_cast<double>(piece.high[0] - piece.low[0]),
                 dy = static_cast<double>(piece.high[1] - piece.low[1]);
    out.extent[side] = std::max(out.extent[side], a.step() * std::hypot(dx, dy));
  }
  return out;
}

// Where the pelvis ends.
struct Pelvis {
  bool seen = false;
  std::optional<double> crests;  // level of the iliac crests, mm; empty: above the scan
};

// Level of the lungs' lower end; empty if no lungs are in view.
std::optional<double> end_of_lungs(const Trunk& found) {
  return found.lungs[1] > found.lungs[0] ? std::optional(found.lungs[0]) : std::nullopt;
}

// In an axial slice the iliac wings are longer than ribs, except beside the lungs, where ribs run along the slice.
// Above the wings a flank without bone follows, then the ribs.
Pelvis find_pelvis(const Anatomy& a, const Mask& trunk, const Trunk& found) {
  constexpr double long_wing = 70, other_wing = 50;  // mm: one side's extent, and the other's
  constexpr double few = 40, flank = 9;              // mm^2 of bone per side; mm
  const Grid& g = a.grid();
  Pelvis out;
  const double top = end_of_lungs(found).value_or(std::numeric_limits<double>::infinity());
  double bare = 0;
  for (std::int64_t k = 0; k < g.size[2] && g.point(0, 0, k)[2] < top && !out.crests; ++k) {
    const Flanks at = flanks_at(a, trunk, k);
    if (!at.seen) continue;
    if (std::min(at.extent[0], at.extent[1]) >= other_wing &&
        std::max(at.extent[0], at.extent[1]) >= long_wing)
      out = {true, std::nullopt}, bare = 0;
    if (!out.seen) continue;
    bare = at.bone[0] < few && at.bone[1] < few ? bare + a.step() : 0;
    if (bare >= flank) out.crests = g.point(0, 0, k)[2] - bare;
  }
  return out;
}

// The column and the front skin at a level, mm; empty if the trunk is not in view there.
struct TrunkPoints {
  Vector3d column, front;
};

std::optional<TrunkPoints> trunk_at(const Anatomy& a, const Mask& trunk, double z) {
  constexpr double half = 30;  // mm to each side of the middle
  const Grid& g = a.grid();
  const auto k = std::lround(g.index(Vector3d(g.origin[0], g.origin[1], z))[2]);
  if (k < 0 || k >= g.size[2]) return std::nullopt;
  Vector3d sum = Vector3d::Zero(), of_bone = Vector3d::Zero();
  double count = 0, bones = 0, front = std::numeric_limits<double>::infinity();
  const auto each = [&](const auto& take) {
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        if (trunk.at(i, j, k)) take(g.point(i, j, k), a.bone.at(i, j, k));
  };
  each([&](const Vector3d& p, bool) { sum += p, ++count; });
  if (count == 0) return std::nullopt;
  const Vector3d middle = sum / count;
  each([&](const Vector3d& p, bool bone) {
    if (std::abs(p[0] - middle[0]) > half) return;
    front = std::min(front, p[1]);
    if (bone && p[1] > middle[1]) of_bone += p, ++bones;
  });
  const Vector3d column = bones > 0 ? Vector3d(of_bone / bones) : middle;
  return TrunkPoints{{column[0], column[1], z}, {middle[0], std::min(front, middle[1]), z}};
}

// Levels that bound the trunk's parts, and the part of a trunk without any.
std::string bound_trunk(const Anatomy& a, const Trunk& found, const Mask& trunk, Landmarks& marks) {
  const double bottom = a.grid().point(0, 0, 0)[2];
  const auto put = [&](const char* joint, const char* bound, double z, double spread, const char* source) {
    const auto points = trunk_at(a, trunk, z);
    if (!points) return;
    marks[joint] = {points->column, spread, 0, source};
    marks[bound] = {points->front, spread, 0, source};
  };
  const auto lungs = end_of_lungs(found);
  constexpr double below_lungs = 25;  // mm that the scan must show, or it may cut the lungs
  if (lungs && *lungs > bottom + below_lungs)
    put("spine_upper", "xiphion", *lungs + lungs_to_xiphion, xiphion_spread,
        "lungs: level of their lower end");
  const Pelvis pelvis = find_pelvis(a, trunk, found);
  if (pelvis.crests)
    put("spine_lower", "omphalion", *pelvis.crests + crest_to_omphalion, omphalion_spread,
        "bone: level of the iliac crests");
  return lungs ? "upper_trunk" : pelvis.seen ? "lower_trunk" : "middle_trunk";
}

// Adds the ends of forearms and shanks whose far joint is missing. They give the planes at elbow and knee their
// direction, and so the table its deviations.
void add_far_ends(const Volume<std::uint8_t>& bones, Landmarks& marks) {
  constexpr double last = 15, beside = 12, least = 40;  // mm
  struct LowerLimb {
    const char *joint, *beyond, *part, *name;
  };
  const Grid& g = bones.grid;
  for (const char* at : {"_left", "_right"})
    for (const LowerLimb& limb : {LowerLimb{"elbow", "wrist", "forearm", "forearm_end"},
                                  LowerLimb{"knee", "ankle", "shank", "shank_end"}}) {
      const auto joint = marks.find(std::string(limb.joint) + at);
      if (joint == marks.end() || marks.contains(std::string(limb.beyond) + at)) continue;
      const int label = part_label(std::string(limb.part) + at);
      std::vector<std::pair<double, Vector3d>> points;  // with their distances from the joint
      double longest = 0;
      for (std::size_t o = 0; o < bones.voxels.size(); ++o) {
        if (bones.voxels[o] != label) continue;
        const auto n = static_cast<std::int64_t>(o);
        const Vector3d p = g.point(n % g.size[0], n / g.size[0] % g.size[1], n / (g.size[0] * g.size[1]));
        points.emplace_back((p - joint->second.point).norm(), p);
        longest = std::max(longest, points.back().first);
      }
      if (longest < least) continue;
      Vector3d sum = Vector3d::Zero();
      double count = 0;
      for (const auto& [distance, p] : points)
        if (distance > longest - last) sum += p, ++count;
      marks[std::string(limb.name) + at] = {Vector3d(sum / count), beside, 0, "bone: where the scan cuts it"};
    }
}

}  // namespace

ForestParts parts_by_forest(const Anatomy& a, const Trunk& found) {
  const Proposal& proposal = *a.proposal;
  const Grid& g = a.grid();
  const std::vector<Choice> chosen = choose_pieces(a, proposal, found.absent);
  ForestParts out;
  Mask trunk{g, std::vector<std::uint8_t>(g.count())};
  out.bones = {g, std::vector<std::uint8_t>(g.count())};
  std::array<double, parts.size()> sum{}, count{};
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::size_t o = g.offset(i, j, k), place = proposal.place_of(g, i, j, k);
        const std::int16_t p = proposal.piece_at[place];
        if (!a.body.voxels[o] || p < 0 || !chosen[static_cast<std::size_t>(p)].taken) continue;
        const BodyPiece& piece = proposal.pieces[static_cast<std::size_t>(p)];
        if (piece.region == BodyRegion::trunk) trunk.voxels[o] = 1;
        const int label =
            piece.region == BodyRegion::trunk
                ? part_label("upper_trunk")
                : label_of(proposal.voxel_class[place], chosen[static_cast<std::size_t>(p)].side);
        if (label == 0 || found.absent[static_cast<std::size_t>(label)]) continue;
        sum[static_cast<std::size_t>(label)] += piece.confidence, ++count[static_cast<std::size_t>(label)];
        out.side_unsure[static_cast<std::size_t>(label)] |= chosen[static_cast<std::size_t>(p)].across_trunk;
        if (a.bone.voxels[o]) out.bones.voxels[o] = static_cast<std::uint8_t>(label);
      }
  for (std::size_t label = 1; label < parts.size(); ++label)
    if (count[label] > 0) out.confidence[label] = sum[label] / count[label];
  for (const ProposedJoint& joint : proposal.joints) {
    const Choice& limb = chosen[joint.piece];
    if (!limb.taken || joint.deviation == 0) continue;
    const std::string name = joint.name.substr(0, joint.name.find('_')) + side_suffix(limb.side);
    // in phantoms whose shoulders are out of view the elbow lies 70 to 95 mm off
    constexpr double without_shoulder = 80;
    const double deviation =
        joint.region == BodyRegion::arm ? std::max(joint.deviation, without_shoulder) : joint.deviation;
    out.landmarks[name] = {joint.point, deviation, 0, "classifier: border of two segments"};
  }
  add_far_ends(out.bones, out.landmarks);
  if (const double trust = out.confidence[static_cast<std::size_t>(part_label("upper_trunk"))]; trust > 0) {
    const int alone = part_label(bound_trunk(a, found, trunk, out.landmarks));
    const PartPlanes planes(out.landmarks);
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          auto& label = out.bones.at(i, j, k);
          if (label == part_label("upper_trunk"))
            label = static_cast<std::uint8_t>(out.landmarks.contains("spine_upper") ||
                                                      out.landmarks.contains("spine_lower")
                                                  ? planes.axial_part(g.point(i, j, k))
                                                  : alone);
        }
    for (const char* part : {"upper_trunk", "middle_trunk", "lower_trunk"})
      out.confidence[static_cast<std::size_t>(part_label(part))] = trust;
  }
  return out;
}

bool hips_near_crests(const Anatomy& a, const Trunk& trunk) {
  constexpr double least = 90;  // mm; of an adult about 150
  if (!trunk.hip[0] || !trunk.hip[1]) return false;
  const Proposal& proposal = *a.proposal;
  const BodyPiece* piece = proposal.piece(BodyRegion::trunk, -1);
  if (!piece) return false;
  const Mask of_trunk = mask_of(a, proposal, static_cast<std::size_t>(piece - proposal.pieces.data()));
  const Pelvis pelvis = find_pelvis(a, of_trunk, trunk);
  const double hips = 0.5 * (trunk.hip[0]->centre[2] + trunk.hip[1]->centre[2]);
  return pelvis.crests && *pelvis.crests - hips < least * trunk.scale;
}

void add_rootless_limbs(const Anatomy& a, const Trunk& trunk, Volume<std::uint8_t>& bones,
                        Landmarks& landmarks) {
  const bool arms = !trunk.shoulder[0] && !trunk.shoulder[1];
  const bool legs = !trunk.hip[0] && !trunk.hip[1] && !trunk.femur[0] && !trunk.femur[1];
  if (!arms && !legs) return;
  const auto rootless = [&](int label) {
    return label > 0 && !is_axial(label) && (label >= part_label("thigh_left") ? legs : arms);
  };
  const ForestParts forest = parts_by_forest(a, trunk);
  for (std::size_t o = 0; o < bones.voxels.size(); ++o)
    if (bones.voxels[o] == 0 && rootless(forest.bones.voxels[o])) bones.voxels[o] = forest.bones.voxels[o];
  const auto of_a = [](const std::string& name, std::initializer_list<std::string_view> stems) {
    return std::ranges::any_of(stems, [&](std::string_view stem) { return name.starts_with(stem); });
  };
  for (const auto& landmark : forest.landmarks)
    if ((arms && of_a(landmark.first, {"elbow", "wrist", "forearm_end"})) ||
        (legs && of_a(landmark.first, {"knee", "ankle", "shank_end"})))
      landmarks.insert(landmark);
}

void doubt_forest_parts(const ForestParts& forest, Segmentation& out) {
  constexpr double unsure = 0.4;
  for (std::size_t label = 1; label < parts.size(); ++label) {
    PartFinding& finding = out.part[label];
    finding.confidence = std::min(finding.confidence, forest.confidence[label]);
    if (finding.volume > 0 && forest.side_unsure[label])
      finding.doubt(unsure, "it lies in front of or behind the trunk, so its side is uncertain");
  }
  // Without a border between them, a trunk part that the scan cuts may hold flesh of its neighbour.
  for (const Part& part : parts) {
    const auto own = static_cast<std::size_t>(part_label(part.name)),
               parent = static_cast<std::size_t>(part_label(part.parent));
    if (part.joint.empty() || out.landmarks.contains(bound_of(part.joint, out.convention))) continue;
    for (const auto& [holder, other] : {std::pair(own, parent), std::pair(parent, own)}) {
      PartFinding& finding = out.part[holder];
      if (!is_axial(static_cast<int>(holder)) || finding.coverage != Coverage::cut ||
          out.part[other].volume > 0 || out.absent[other])
        continue;
      finding.doubt(unsure, std::string("may include flesh of the ") + in_words(parts[other].name));
    }
  }
  out.warnings.push_back(
      {WarningKind::body, Severity::doubt,
       "the scan shows neither both hips nor both shoulders, so a trained classifier named "
       "the parts by their tissue; their borders are rough, see the deviations"});
}

}  // namespace borelli
