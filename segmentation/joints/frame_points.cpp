#include "segmentation/joints/frame_points.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "segmentation/body/bone_edges.hpp"
#include "segmentation/joints/vertebrae.hpp"
#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

constexpr double bone = 150;  // CT number

std::optional<Vector3d> point_named(const Landmarks& marks, const std::string& name) {
  const auto it = marks.find(name);
  return it == marks.end() ? std::nullopt : std::optional(it->second.point);
}

// Midpoint of the hips; in a body with one leg, mid_hip from the mirror image.
std::optional<Vector3d> middle_of_hips(const Landmarks& marks) {
  const auto left = point_named(marks, "hip_left"), right = point_named(marks, "hip_right");
  if (left && right) return Vector3d(0.5 * (*left + *right));
  return left || right ? point_named(marks, "mid_hip") : std::nullopt;
}

// Bone voxels of the work grid that belong to certain parts; their centres, mm, LPS.
template <class Belongs>
std::vector<Vector3d> bones_of(const Anatomy& a, const Volume<std::uint8_t>& owner, const Belongs& belongs) {
  std::vector<Vector3d> places;
  const auto& g = a.grid();
  const auto& mask = a.bone.voxels;
  for (auto at = mask.begin(); (at = std::find(at, mask.end(), 1)) != mask.end(); ++at) {
    const std::int64_t o = at - mask.begin();
    if (belongs(owner.voxels[static_cast<std::size_t>(o)]))
      places.push_back(
          g.point(Vector3d(static_cast<double>(o % g.size[0]), static_cast<double>(o / g.size[0] % g.size[1]),
                           static_cast<double>(o / g.size[0] / g.size[1]))));
  }
  return places;
}

Vector3d mean(const std::vector<Vector3d>& places) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : places) sum += p;
  return sum / static_cast<double>(places.size());
}

// ---- pelvis

// The PSIS is the posterior corner of the iliac wing: of all bone beside the sacrum it reaches farthest
// backwards and, less so, outwards. Straight backwards the sacrum's crest may reach farther.
void find_psis(const Anatomy& a, const Volume<std::uint8_t>& owner, double s, Landmarks& marks) {
  constexpr int pelvis = part_label("lower_trunk"), belly = part_label("middle_trunk");
  const auto hips = middle_of_hips(marks);
  if (!hips) return;
  const Vector3d middle = *hips;
  const Matrix3d axes = trunk_axes(marks);
  const auto bones = bones_of(a, owner, [](int part) { return part == pelvis || part == belly; });
  // Large voxels miss the last d of the corner (half of over_fine: the wing is thinner than a voxel). On a
  // corner of radius R the hindmost visible place then varies along a chord: sqrt(2 R d) along the rim.
  constexpr double corner = 80;
  const double deviation = std::hypot(7, std::sqrt(corner * s * a.over_fine()));
  for (const int side : {left_side, right_side}) {
    const Vector3d outwards = side_sign(side) * axes.col(0);
    constexpr double turn = 25 * M_PI / 180;
    const Vector3d direction = std::cos(turn) * axes.col(1) + std::sin(turn) * outwards;
    std::vector<Vector3d> beside;
    for (const Vector3d& p : bones) {
      const Vector3d d = p - middle;
      const double out = d.dot(outwards), up = d.dot(axes.col(2));
      if (out > 25 * s && out < 85 * s && up > 40 * s && up < 140 * s && d.dot(axes.col(1)) > 20 * s)
        beside.push_back(p);
    }
    const auto farthest = std::max_element(
        beside.begin(), beside.end(),
        [&](const Vector3d& p, const Vector3d& q) { return p.dot(direction) < q.dot(direction); });
    if (farthest == beside.end() || a.near_edge(*farthest, 15)) continue;
    // takes the centre of a blunt corner, not a chance voxel
    constexpr double depth = 6, reach = 28;
    Vector3d sum = Vector3d::Zero();
    double weight = 0;
    for (const Vector3d& p : beside) {
      const double w = depth - (*farthest - p).dot(direction);
      if (w <= 0 || (p - *farthest).norm() > reach * s) continue;
      sum += w * p, weight += w;
    }
    Vector3d spine = sum / weight;
    // refines the position backwards in the scan itself
    const CloseUp view = close_up(*a.source, spine, 25);
    double r = 10;
    while (r > -6 && view.at(spine + r * axes.col(1)) < bone) r -= 0.5;
    spine += r * axes.col(1);
    marks[std::string("psis") + side_suffix(side)] = {spine, deviation, 0,
                                                      "bone: hindmost point of the ilium's wing"};
  }
}

// ---- thorax

// Thoracic vertebrae with their discs grow in height by about half from the first to the twelfth. Returns the
// position of the disc below the n-th, as a fraction of the distance from C7/T1 to T12/L1.
double share_of_thorax(int n) {
  constexpr double growth = 0.55 / 11;
  const auto sum = [](int count) { return count + growth * 0.5 * count * (count - 1); };
  return sum(n) / sum(12);
}

// CT number along the column less its mean over 27 mm, one value per mm downwards from `top` (mm, patient z).
std::vector<double> discs_and_bodies(const Anatomy& a, const Trunk& trunk, double top, double length) {
  constexpr double between = 30;
  std::vector<Vector3d> middle;
  for (double down = 0; down < length + between; down += between)
    middle.push_back(vertebral_body(a, trunk, top - down));
  const Matrix3d to_index = a.source->grid.axes.inverse();
  std::vector<double> level;
  for (double down = 0; down <= length; down += 1) {
    const auto n = static_cast<std::size_t>(down / between);
    Vector3d centre = middle[n] + (down / between - static_cast<double>(n)) * (middle[n + 1] - middle[n]);
    double sum = 0, count = 0;
    for (double x = -6; x <= 6; x += 2)
      for (double y = -6; y <= 6; y += 2) {
        double value = 0;
        if (!sample(*a.source, to_index * (centre + Vector3d(x, y, 0) - a.source->grid.origin), value))
          continue;
        sum += hu_of(value, a.source->quantity), ++count;
      }
    level.push_back(count > 0 ? sum / count : 0);
  }
  std::vector<double> out(level.size());
  for (std::size_t n = 0; n < level.size(); ++n) {
    const std::size_t first = n > 13 ? n - 13 : 0, last = std::min(level.size(), n + 14);
    double sum = 0;
    for (std::size_t q = first; q < last; ++q) sum += level[q];
    out[n] = level[n] - sum / static_cast<double>(last - first);
  }
  return out;
}

// The disc T8/T9 by fitting the upper ten thoracic discs together: the length of the column, within a sixth
// of the usual one, that puts them on the softest places. In mm below the neck's disc. Empty if the scan does
// not resolve discs or they do not stand out.
std::optional<double> disc_below_t8(const Anatomy& a, const Trunk& trunk, double neck, double usual) {
  if (a.source->grid.spacing().maxCoeff() > 5) return std::nullopt;
  constexpr double above = 10;
  const auto profile = discs_and_bodies(a, trunk, neck + above, above + 1.2 * usual);
  double square = 0;
  for (const double v : profile) square += v * v;
  const double usual_swing = std::sqrt(square / static_cast<double>(profile.size()));
  double best = 0, at = 0;
  for (double length = usual * 5 / 6; length <= usual * 7 / 6; length += 1)
    for (double shift = -4; shift <= 4; shift += 1) {
      double soft = 0;
      for (int n = 1; n <= 10; ++n) {
        const auto z = static_cast<std::size_t>(std::lround(above + shift + share_of_thorax(n) * length));
        soft -= profile[z] / 10;
      }
      if (soft > best) best = soft, at = shift + share_of_thorax(8) * length;
    }
  constexpr double stands_out = 0.7;
  return best > stands_out * usual_swing ? std::optional(at) : std::nullopt;
}

// The spinous process of T8 descends to about the level of the disc below it.
void find_t8(const Anatomy& a, const Trunk& trunk, Landmarks& marks) {
  const auto hips = middle_of_hips(marks), neck = point_named(marks, "neck");
  if (!hips || !neck) return;
  const double neck_deviation = marks.at("neck").deviation;
  // disc T12/L1 as in column_levels.hpp
  const double usual = 0.515 * ((*neck)[2] - (*hips)[2]);
  const auto counted = neck_deviation < 5 ? disc_below_t8(a, trunk, (*neck)[2], usual) : std::nullopt;
  const double z = (*neck)[2] - counted.value_or(share_of_thorax(8) * usual);
  if (!trunk.spine_holds(z)) return;
  const auto tip = spinous_tip(a, vertebral_body(a, trunk, z), trunk.scale);
  if (!tip || a.near_edge(*tip, 10)) return;
  constexpr double half_a_vertebra = 12;
  const double level = counted ? 6 : std::hypot(half_a_vertebra, neck_deviation);
  // the process is thinner than large voxels and slopes down, so its tip may show in one voxel and not in the
  // next
  marks["t8"] = {Vector3d((*tip)[0], (*tip)[1], z), std::hypot(level, 3 * a.over_fine()), 0,
                 counted ? "bone: spinous process, counted by the discs above it"
                         : "bone: spinous processes at a level by proportion between neck and hips"};
}

// ---- forearm

// A section perpendicular to the forearm: positions of its bone in the plane, mm; own(p): whether a point
// counts.
template <class Own>
std::vector<Vector2d> section(const CloseUp& view, const Vector3d& centre, const Vector3d& x,
                              const Vector3d& y, double reach, const Own& own) {
  std::vector<Vector2d> places;
  for (double u = -reach; u <= reach; u += 1)
    for (double v = -reach; v <= reach; v += 1)
      if (const Vector3d p = centre + u * x + v * y; view.at(p) >= bone && own(p)) places.emplace_back(u, v);
  return places;
}

// The two bones of a forearm in a section: the direction from the thinner one (ulna) to the thicker one
// (radius), and the position of the waist between them.
struct TwoBones {
  Vector2d direction;  // unit, from ulna to radius
  double waist = 0;    // its position along that direction, mm
  double depth = 0;    // 1: a gap; 0: as broad as the thinner bone
};

std::optional<TwoBones> two_bones(const std::vector<Vector2d>& places) {
  if (places.size() < 30) return std::nullopt;
  Vector2d centre = Vector2d::Zero();
  for (const auto& p : places) centre += p;
  centre /= static_cast<double>(places.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const auto& p : places) spread += (p - centre) * (p - centre).transpose();
  const Vector2d wide = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(1);
  constexpr int half = 50;  // mm
  std::array<double, 2 * half + 1> breadth{};
  for (const auto& p : places)
    if (const auto n = std::lround((p - centre).dot(wide)) + half; n >= 0 && n <= 2 * half)
      ++breadth[static_cast<std::size_t>(n)];
  const double all = static_cast<double>(places.size());
  std::optional<TwoBones> two;
  double below = 0;
  for (auto n = breadth.begin(); n != breadth.end(); below += *n++) {
    if (below < 0.12 * all || below + *n > 0.88 * all) continue;
    const double broad = std::min(*std::max_element(breadth.begin(), n), *std::max_element(n, breadth.end()));
    const double depth = 1 - *n / broad;
    if (two && depth <= two->depth) continue;
    const double sign = below + 0.5 * *n < 0.5 * all ? 1 : -1;
    const auto place = static_cast<double>(n - breadth.begin() - half) + centre.dot(wide);
    two = {sign * wide, sign * place, depth};
  }
  return two;
}

// Distance to the end of bone along a direction, mm; empty if bone continues beyond `most`.
std::optional<double> end_of_bone(const CloseUp& view, const Vector3d& from, const Vector3d& direction,
                                  double most) {
  double before = view.at(from);
  for (double r = 0.5; r <= most; r += 0.5) {
    const double here = view.at(from + r * direction);
    if (here < bone) return r - 0.5 * (bone - here) / (before - here);
    before = here;
  }
  return std::nullopt;
}

// Mean of the bone's ends within 2 mm of the farthest, along lines in direction `down` from some places of a
// section.
std::optional<Vector3d> far_end(const CloseUp& view, const std::vector<Vector3d>& from,
                                const Vector3d& down) {
  constexpr double most = 28;
  std::vector<std::pair<double, Vector3d>> ends;
  for (const Vector3d& p : from)
    if (const auto r = end_of_bone(view, p, down, most)) ends.emplace_back(*r, p + *r * down);
  // if most lines continue into the next bone, no end is visible
  if (ends.size() < 4 || 2 * ends.size() < from.size()) return std::nullopt;
  // a few lines may leave through a gap between the carpals
  std::sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const double last = ends[ends.size() - 1 - ends.size() / 20].first;
  std::vector<Vector3d> tips;
  for (const auto& [r, p] : ends)
    if (std::abs(r - last) < 2) tips.push_back(p);
  return mean(tips);
}

void find_styloids(const Anatomy& a, const Volume<std::uint8_t>& owner, const std::string& at, double s,
                   Landmarks& marks) {
  const auto elbow = point_named(marks, "elbow" + at), wrist = point_named(marks, "wrist" + at);
  if (!elbow || !wrist || a.near_edge(*wrist, 25)) return;
  const Vector3d down = (*wrist - *elbow).normalized();
  const Vector3d x = down.unitOrthogonal(), y = down.cross(x);
  const CloseUp view = close_up(*a.source, *wrist, 60 * s);
  // the other arm, or what this arm lies on, may be as near
  const int forearm = part_label("forearm" + at), hand = part_label("hand" + at);
  const auto own = [&](const Vector3d& p) {
    const Vector3d index = owner.grid.index(p);
    const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
    const int part = owner.grid.holds(i, j, k) ? owner.at(i, j, k) : 0;
    return part == forearm || part == hand;
  };
  // finds the section where the bones separate, above the joint between them
  std::optional<TwoBones> two;
  for (double up = 16; up <= 46; up += 6) {
    const auto here = two_bones(section(view, *wrist - up * s * down, x, y, 32 * s, own));
    if (here && (!two || here->depth > two->depth)) two = here;
  }
  if (!two || two->depth < 0.4) return;
  // lines start where both bones are broad, just above the wrist
  const Vector3d start = *wrist - 9 * s * down;
  std::vector<Vector3d> of_ulna, of_radius;
  double side = -1e9;
  const auto near = section(view, start, x, y, 32 * s, own);
  for (const auto& p : near) side = std::max(side, p.dot(two->direction));
  for (const auto& p : near) {
    const double along = p.dot(two->direction);
    const Vector3d place = start + p[0] * x + p[1] * y;
    if (along < two->waist) of_ulna.push_back(place);
    if (along > side - 9 * s) of_radius.push_back(place);
  }
  const double coarse = view.coarsest > 3 ? view.coarsest : 0;  // thick slices blur ends over a slice
  // the search starts from the wrist: its deviation beyond the usual 5 mm carries over
  const double doubt = std::sqrt(std::max(0.0, std::pow(marks.at("wrist" + at).deviation, 2) - 25));
  const double deviation =
      std::hypot(std::hypot(4, coarse), std::max({1.2 * a.gaps_unseen(s), doubt, 3.5 * a.over_fine()}));
  if (const auto end = far_end(view, of_ulna, down))
    marks["ulnar_styloid" + at] = {*end, deviation, 0, "bone: end of the ulna"};
  if (const auto end = far_end(view, of_radius, down))
    marks["radial_styloid" + at] = {*end, deviation, 0, "bone: end of the radius, at its outer side"};
}

// ---- foot

struct FootFrame {
  Vector3d heel, forward, outwards;  // unit: along the foot; perpendicular to it, towards the little toe
  double length = 0;

  double along(const Vector3d& p) const { return (p - heel).dot(forward) / length; }
  double out(const Vector3d& p) const { return (p - heel).dot(outwards); }
};

// How far the bones of a foot reach outwards (`sign` +1) or inwards (-1) between two fractions of its length,
// mm.
double side_of(const std::vector<Vector3d>& bones, const FootFrame& foot, double sign, double first,
               double last) {
  double out = -1e9;
  for (const Vector3d& p : bones)
    if (foot.along(p) > first && foot.along(p) < last) out = std::max(out, sign * foot.out(p));
  return out;
}

// Centre of the bone at a position on the sole; the height is the bone's mean.
std::optional<Vector3d> bone_over(const std::vector<Vector3d>& bones, const FootFrame& foot, double along,
                                  double out, double half) {
  std::vector<Vector3d> here;
  for (const Vector3d& p : bones)
    if (std::abs(foot.along(p) - along) * foot.length < half && std::abs(foot.out(p) - out) < half)
      here.push_back(p);
  if (here.size() < 3) return std::nullopt;
  const Vector3d middle = mean(here);
  return Vector3d(middle + (along - foot.along(middle)) * foot.length * foot.forward +
                  (out - foot.out(middle)) * foot.outwards);
}

void find_metatarsals(const Anatomy& a, const Volume<std::uint8_t>& owner, const std::string& at, double s,
                      Landmarks& marks) {
  const auto heel = point_named(marks, "heel" + at), toe = point_named(marks, "toe_tip" + at),
             inner = point_named(marks, "medial_malleolus" + at),
             outer = point_named(marks, "lateral_malleolus" + at);
  if (!heel || !toe || !inner || !outer) return;
  FootFrame foot{*heel, (*toe - *heel).normalized(), *outer - *inner, (*toe - *heel).norm()};
  foot.outwards = (foot.outwards - foot.outwards.dot(foot.forward) * foot.forward).normalized();
  const int part = part_label("foot" + at);
  const auto bones = bones_of(a, owner, [&](int own) { return own == part; });
  // Thick slices and toes held close hide the heads' position along the foot: it is by proportion, within
  // about 4 % of the foot's length, which hardly turns the foot's frame. Sides and heights are measured.
  constexpr double ball = 0.73, little_ball = 0.64, spread = 0.06, radius_1 = 7.5, radius_5 = 5.5;
  const double first = radius_1 * s - side_of(bones, foot, -1, ball - spread, ball + spread),
               fifth = side_of(bones, foot, 1, little_ball - spread, little_ball + spread) - radius_5 * s;
  const auto put = [&](const char* name, double share, double out, double deviation, const char* source) {
    if (const auto head = bone_over(bones, foot, share, out, 8 * s))
      marks[name + at] = {*head, deviation, 0, source};
  };
  put("metatarsal_1", ball, first, 7, "bone: inner side of the ball of the foot");
  put("metatarsal_2", ball, first + 0.27 * (fifth - first), 7, "bone: beside the first metatarsal's head");
  put("metatarsal_5", little_ball, fifth, 9, "bone: outer side of the ball of the foot");
}

}  // namespace

void find_frame_points(const Anatomy& a, const Trunk& trunk, const Volume<std::uint8_t>& owner,
                       Landmarks& marks) {
  find_psis(a, owner, trunk.scale, marks);
  find_t8(a, trunk, marks);
  for (const int side : {left_side, right_side}) {
    find_styloids(a, owner, side_suffix(side), trunk.scale, marks);
    find_metatarsals(a, owner, side_suffix(side), trunk.scale, marks);
  }
}

}  // namespace borelli
