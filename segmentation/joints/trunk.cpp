#include "segmentation/joints/trunk.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/joints/heads_in_body.hpp"
#include "segmentation/joints/lone_heads.hpp"
#include "segmentation/joints/one_side.hpp"
#include "segmentation/joints/round_heads.hpp"
#include "segmentation/proposal/limb_roots.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

struct Spacing {
  double least, most;  // between left and right, mm
};
// hip centres: 130 to 215 mm in adults; shoulders: 260 to 430 mm
constexpr Spacing hips_apart{125, 215}, shoulders_apart{260, 430};
// how far a found head may lie from every place searched so far before its own place is searched too, mm.
// Sockets fit femoral heads closely, so there only a search from nearby separates the two.
constexpr double hips_again = 1, shoulders_again = 8;
// how far beside a poor sphere a head is searched, mm
constexpr double beside = 10;

struct Pair {
  FoundSphere left, right;
  double score = 0;
};

template <class Fits>
std::vector<Pair> pairs(const std::vector<FoundSphere>& balls, const LimbRoots& roots, Spacing apart,
                        double level, const Fits& fits) {
  std::vector<Pair> out;
  for (const auto& l : balls)
    for (const auto& r : balls) {
      const Vector3d d = l.centre - r.centre;
      if (d[0] < apart.least || d[0] > apart.most) continue;
      const double score = std::sqrt(l.score * r.score) * roots.likelihood(l.centre, r.centre) *
                           std::exp(-std::pow(d[1] / level, 2) - std::pow(d[2] / level, 2));
      if (score < 0.004 || !fits(l.centre, r.centre)) continue;
      out.push_back({l, r, score});
    }
  std::stable_sort(out.begin(), out.end(), [](const Pair& a, const Pair& b) { return a.score > b.score; });
  return out;
}

// Spheres fitted about some places of one side.
using Balls = std::vector<FoundSphere>;

// The likeliest pair among the spheres of two sides (heads, their sockets' surfaces, tubers, trochanters):
// good agreement, equal radii of a head's size (19 to 29 mm in adults), and distance, level and place as
// `fits` requires. holds(l, r) tests the spheres themselves.
// Skips pairs whose two spheres both lie within `one_place` of those of `other_than`, unless its score is 0.
constexpr double one_place = 12;  // mm
template <class Fits, class Holds>
Pair likeliest(const Anatomy& a, const LimbRoots& roots, const Balls& left, const Balls& right, Spacing apart,
               double level, const Fits& fits, const Holds& holds, const Pair& other_than = {}) {
  Pair best;
  for (const auto& l : left)
    for (const auto& r : right) {
      const Vector3d d = l.centre - r.centre;
      if (d[0] < apart.least || d[0] > apart.most) continue;
      if (other_than.score > 0 && (l.centre - other_than.left.centre).norm() < one_place &&
          (r.centre - other_than.right.centre).norm() < one_place)
        continue;
      const double score = agreement(a, l) * agreement(a, r) * roots.likelihood(l.centre, r.centre) *
                           std::exp(-std::pow((l.radius - r.radius) / 2, 2)) *
                           head_size(0.5 * (l.radius + r.radius)) *
                           std::exp(-std::pow(d[1] / level, 2) - std::pow(d[2] / level, 2));
      if (score > best.score && fits(l.centre, r.centre) && holds(l, r)) best = {l, r, score};
    }
  return best;
}

// The likeliest pair of heads about the best voted places. Votes alone do not distinguish heads from other
// round bone (tubers, trochanters), least of all where a coarse grid fuses head and socket, and may be off by
// a head's radius. So several places are measured. The search repeats about the likeliest heads if they lie
// more than `again` mm from all places, since from some millimetres away some edges are missed.
template <class Fits, class Holds>
std::optional<Pair> find_heads(const Anatomy& a, const LimbRoots& roots, RoundHeads& candidates,
                               Spacing apart, double level, double again, const Fits& fits,
                               const Holds& holds, const Pair& other_than = {}) {
  constexpr double same = 15;  // mm; spheres are searched within 30 mm of a place
  constexpr std::size_t most_places = 5;
  struct Side {
    std::vector<Vector3d> places;
    Balls balls;
  };
  std::array<Side, 2> sides;
  const auto search_near = [&](Side& side, const Vector3d& place, double reach) {
    if (std::any_of(side.places.begin(), side.places.end(),
                    [&](const Vector3d& other) { return (other - place).norm() < reach; }))
      return false;
    side.places.push_back(place);
    const Balls& more = candidates.about(place);
    side.balls.insert(side.balls.end(), more.begin(), more.end());
    return true;
  };
  const auto voted = pairs(candidates.votes(), roots, apart, level, fits);
  if (voted.empty()) return std::nullopt;
  for (const Pair& pair : voted) {
    if (sides[0].places.size() < most_places) search_near(sides[0], pair.left.centre, same);
    if (sides[1].places.size() < most_places) search_near(sides[1], pair.right.centre, same);
  }
  Pair best;
  const auto improve = [&] {
    best = likeliest(a, roots, sides[0].balls, sides[1].balls, apart, level, fits, holds, other_than);
    for (int round = 0; round < 3 && best.score > 0; ++round) {
      const bool left = search_near(sides[0], best.left.centre, again),
                 right = search_near(sides[1], best.right.centre, again);
      if (!left && !right) break;
      best = likeliest(a, roots, sides[0].balls, sides[1].balls, apart, level, fits, holds, other_than);
    }
  };
  improve();
  // If the edges scatter by more than the voxels explain, the sphere is a compromise between head and socket.
  // The head itself may then lie beside it: outwards, or else anywhere.
  const double scatter = 0.4 * a.source->grid.spacing().maxCoeff();
  const auto search_beside = [&](const std::vector<Vector3d>& outwards_on_the_left) {
    bool searched = false;
    for (std::size_t n = 0; n < 2 && best.score > 0; ++n) {
      const FoundSphere head = n == 0 ? best.left : best.right;
      if (head.deviation <= scatter) continue;
      for (const Vector3d& direction : outwards_on_the_left)
        searched = search_near(sides[n], head.centre + beside * (n == 0 ? direction : Vector3d(-direction)),
                               again) ||
                   searched;
    }
    if (searched) improve();
  };
  search_beside({Vector3d::UnitX()});
  search_beside(
      {-Vector3d::UnitX(), Vector3d::UnitY(), -Vector3d::UnitY(), Vector3d::UnitZ(), -Vector3d::UnitZ()});
  if (best.score > 0) {
    // The next likely place may be the true one. Scores are not probabilities, so the power 2 was chosen on
    // warped bodies: with 4, hips that were 30 mm off had deviations of 4 to 6 mm.
    const Pair rival = likeliest(a, roots, sides[0].balls, sides[1].balls, apart, level, fits, holds, best);
    const double odds = std::pow(rival.score / best.score, 2), share = std::sqrt(odds / (1 + odds) / 3);
    best.left.rival = share * (rival.left.centre - best.left.centre).norm();
    best.right.rival = share * (rival.right.centre - best.right.centre).norm();
    return best;
  }
  if (other_than.score > 0) return std::nullopt;  // votes may be off by a head's radius
  const auto voted_head = std::find_if(voted.begin(), voted.end(),
                                       [&](const Pair& pair) { return holds(pair.left, pair.right); });
  if (voted_head == voted.end()) return std::nullopt;
  best = *voted_head;
  best.left.deviation = best.right.deviation = 6;
  return best;
}

// mm beyond what hides a femur: a humeral head 40 mm above the scan's lower end was 20 mm off
constexpr double above_end = 12;

// mm between a head's centre and the scan's upper end: a sphere on part of a head lies up to 30 mm too low;
// without the iliac spines, about 80 mm above the hips, a hip was 20 mm off
constexpr double below_end = 55, below_ilium = 85;

void find_hips(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates, const Pair& other_than,
               Trunk& trunk) {
  const LimbRoots roots(a, BodyRegion::leg);
  // if the forest is sure of both legs, no sacrum need be seen: the ICRP female's is no denser than flesh
  const auto fits = [&](const Vector3d& l, const Vector3d& r) {
    return roots.sure() ? body.deep_below_lungs(l, r) : body.near_hips(l, r);
  };
  const auto holds = [&](const FoundSphere& l, const FoundSphere& r) { return body.are_hips(l, r); };
  auto heads = find_heads(a, roots, candidates, hips_apart, 25, hips_again, fits, holds, other_than);
  if (!heads) {
    const auto near = [&](const Vector3d& l, const Vector3d& r) { return body.near_hips(l, r); };
    heads = find_heads(a, {}, candidates, hips_apart, 25, hips_again, near, holds, other_than);
  }
  // just above the scan's end, sockets pass for heads if the scan cuts the heads; the better pair wins
  constexpr double apart = 30;  // mm, between spheres about one hip
  if (!heads || body.cuts(heads->left, apart) || body.cuts(heads->right, apart)) {
    const auto may_be = [&](const FoundSphere& l, const FoundSphere& r) { return body.may_be_hips(l, r); };
    const auto other = find_heads(a, roots, candidates, hips_apart, 25, hips_again, fits, may_be, other_than);
    // alone they must be sure: the lower two thirds of heads score .037 to .13 (four bodies); smaller pieces,
    // ilia and edges of sockets at most .021
    constexpr double sure = 0.03;
    if (!heads && !(other && other->score > sure)) return;
    if (!heads || (other && other->score > heads->score)) {
      heads = other;
      heads->left.cut = body.cuts(heads->left), heads->right.cut = body.cuts(heads->right);
    }
  }
  for (FoundSphere* head : {&heads->left, &heads->right})
    head->cut = head->cut || body.cuts_from_above(*head, below_ilium) ||
                a.near_edge(head->centre, head->radius + a.step());
  trunk.hip[left_side] = heads->left;
  trunk.hip[right_side] = heads->right;
}

void find_shoulders(const Anatomy& a, const HeadsInBody& body, RoundHeads& candidates, Trunk& trunk) {
  const bool hips = trunk.hip[0] && trunk.hip[1];
  const double above = hips ? std::min(trunk.hip[0]->centre[2], trunk.hip[1]->centre[2]) + 250 : -1e9;
  const auto fits = [&](const Vector3d& l, const Vector3d& r) {
    const Vector3d m = 0.5 * (l + r);
    if (l[2] < above || r[2] < above) return false;
    if (hips && std::abs(m[0] - 0.5 * (trunk.hip[0]->centre[0] + trunk.hip[1]->centre[0])) > 80) return false;
    return body.at_shoulders(l, r);
  };
  const auto holds = [&](const FoundSphere& l, const FoundSphere& r) {
    return body.solid(l) && body.solid(r);
  };
  const LimbRoots roots(a, BodyRegion::arm);
  auto heads = find_heads(a, roots, candidates, shoulders_apart, 50, shoulders_again, fits, holds);
  if (!heads) heads = find_heads(a, {}, candidates, shoulders_apart, 50, shoulders_again, fits, holds);
  if (!heads) return;
  // a head that the scan's side cuts would mislead the other, as would a rib's end for a head out of view:
  // true pairs score .2 to .3, false ones at most .005
  constexpr double unsure = 0.03;
  if (hips && (heads->score < unsure || a.near_edge(heads->left.centre, heads->left.radius) !=
                                            a.near_edge(heads->right.centre, heads->right.radius))) {
    find_one_shoulder(a, body, candidates, trunk);
    if (trunk.shoulder[0]) return;
  }
  for (FoundSphere* head : {&heads->left, &heads->right})
    head->cut = body.cuts_from_above(*head, below_end) || body.cuts(*head, above_end) ||
                a.near_edge(head->centre, head->radius);
  trunk.shoulder[left_side] = heads->left;
  trunk.shoulder[right_side] = heads->right;
}

// The first row of a level in which the column may lie. Between the lungs it lies behind the middle of the
// trunk, and in front of it the heart, which contrast makes as dense as bone.
std::int64_t first_row_of_column(const Anatomy& a, const Trunk& trunk, std::int64_t mid, std::int64_t k) {
  const auto& g = a.grid();
  const double z = g.origin[2] + a.step() * static_cast<double>(k);
  if (z <= trunk.lungs[0] || z >= trunk.lungs[1] || mid < 0 || mid >= g.size[0]) return 0;
  std::int64_t front = 0, back = g.size[1] - 1;
  while (front < back && !a.body.at(mid, front, k)) ++front;
  while (back > front && !a.body.at(mid, back, k)) --back;
  return (front + back) / 2;
}

// sum of the depth within bone over a box about each voxel of a slice: favours vertebral bodies over their
// arches. Leaves out the rows before `first_row`.
std::vector<float> blurred_slice(const Anatomy& a, std::int64_t first_row, std::int64_t k,
                                 std::int64_t half) {
  const auto nx = a.grid().size[0], ny = a.grid().size[1];
  std::vector<double> sum(static_cast<std::size_t>((nx + 1) * (ny + 1)), 0);
  const auto at = [&](std::int64_t i, std::int64_t j) -> double& {
    return sum[static_cast<std::size_t>(j * (nx + 1) + i)];
  };
  for (std::int64_t j = 0; j < ny; ++j)
    for (std::int64_t i = 0; i < nx; ++i)
      at(i + 1, j + 1) =
          at(i, j + 1) + at(i + 1, j) - at(i, j) + (j < first_row ? 0 : a.within_bone.at(i, j, k));
  std::vector<float> out(static_cast<std::size_t>(nx * ny));
  for (std::int64_t j = 0; j < ny; ++j)
    for (std::int64_t i = 0; i < nx; ++i) {
      const auto i0 = std::max<std::int64_t>(0, i - half), i1 = std::min(nx, i + half + 1),
                 j0 = std::max<std::int64_t>(0, j - half), j1 = std::min(ny, j + half + 1);
      out[static_cast<std::size_t>(j * nx + i)] =
          static_cast<float>(at(i1, j1) - at(i0, j1) - at(i1, j0) + at(i0, j0));
    }
  return out;
}

}  // namespace

void find_spine(const Anatomy& a, double x, double bottom_z, double top_z, double far, double leaning,
                Trunk& trunk) {
  const auto& g = a.grid();
  const auto k0 =
      std::clamp<std::int64_t>(std::lround((bottom_z - g.origin[2]) / a.step()), 0, g.size[2] - 1);
  const auto k1 = std::clamp<std::int64_t>(std::lround((top_z - g.origin[2]) / a.step()), 0, g.size[2] - 1);
  const auto reach = std::lround(60 / a.step());
  const auto mid = std::lround((x - g.origin[0]) / a.step());
  const auto i0 = std::max<std::int64_t>(1, mid - reach), i1 = std::min(g.size[0] - 2, mid + reach);
  if (k1 <= k0 || i1 <= i0) return;
  const auto nu = i1 - i0 + 1, ny = g.size[1], nk = k1 - k0 + 1;
  std::vector<float> best(static_cast<std::size_t>(nu * ny), 0), next(best.size());
  std::vector<std::int8_t> from(static_cast<std::size_t>(nu * ny * nk), 0);
  const auto half = std::lround(15 / a.step());
  const auto box = static_cast<double>((2 * half + 1) * (2 * half + 1));
  for (std::int64_t k = k0; k <= k1; ++k) {
    const auto score = blurred_slice(a, first_row_of_column(a, trunk, mid, k), k, half);
    const double usual = far + leaning * a.step() * static_cast<double>(k - k0);
    for (std::int64_t j = 0; j < ny; ++j)
      for (std::int64_t u = 0; u < nu; ++u) {
        float top = -1;
        std::int8_t step = 4;
        for (std::int8_t s = 0; s < 9; ++s) {
          const std::int64_t uu = u + s % 3 - 1, jj = j + s / 3 - 1;
          if (uu < 0 || jj < 0 || uu >= nu || jj >= ny) continue;
          const float b = best[static_cast<std::size_t>(jj * nu + uu)] - (s == 4 ? 0.F : 0.5F);
          if (b > top) top = b, step = s;
        }
        const double aside = a.step() * std::abs(static_cast<double>(i0 + u - mid));
        next[static_cast<std::size_t>(j * nu + u)] =
            top + score[static_cast<std::size_t>(j * g.size[0] + i0 + u)] -
            static_cast<float>(0.015 * box *
                               (std::max(0.0, aside - 15) + std::pow(std::max(0.0, aside - usual), 2)));
        from[static_cast<std::size_t>(((k - k0) * ny + j) * nu + u)] = step;
      }
    std::swap(best, next);
  }
  const auto end = std::max_element(best.begin(), best.end()) - best.begin();
  std::int64_t u = end % nu, j = end / nu;
  std::vector<Vector3d> column(static_cast<std::size_t>(nk));
  for (std::int64_t k = k1; k >= k0; --k) {
    column[static_cast<std::size_t>(k - k0)] =
        g.point(Vector3d(static_cast<double>(i0 + u), static_cast<double>(j), static_cast<double>(k)));
    const auto s = from[static_cast<std::size_t>(((k - k0) * ny + j) * nu + u)];
    u += s % 3 - 1;
    j += s / 3 - 1;
  }
  // smooths over a vertebra's height
  const auto n = std::lround(15 / a.step());
  for (std::int64_t k = 0; k < nk; ++k) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (auto q = std::max<std::int64_t>(0, k - n); q <= std::min(nk - 1, k + n); ++q, ++count)
      sum += column[static_cast<std::size_t>(q)];
    Vector3d p = sum / count;
    p[2] = column[static_cast<std::size_t>(k)][2];
    trunk.spine.push_back(p);
  }
}

Vector3d Trunk::spine_at(double z) const {
  if (spine.size() < 2) return Vector3d(0, 0, z);
  const double t = std::clamp((z - spine.front()[2]) / (spine[1][2] - spine[0][2]), 0.0,
                              static_cast<double>(spine.size() - 1));
  const auto n = std::min(static_cast<std::size_t>(t), spine.size() - 2);
  const double f = t - static_cast<double>(n);
  Vector3d p = (1 - f) * spine[n] + f * spine[n + 1];
  p[2] = z;
  return p;
}

bool Trunk::spine_holds(double z) const {
  return spine.size() > 1 && z >= spine.front()[2] && z <= spine.back()[2];
}

double Trunk::middle(double z) const {
  if (spine.size() > 1) return spine_at(z)[0];
  if (hip[0] && hip[1]) return 0.5 * (hip[0]->centre[0] + hip[1]->centre[0]);
  return 0;
}

Trunk find_trunk(const Anatomy& a, const AbsentParts& absent,
                 const std::array<std::optional<FoundSphere>, 2>& not_hips) {
  Trunk trunk;
  trunk.absent = absent;
  const bool legs = !is_absent(absent, "thigh", "_left") && !is_absent(absent, "thigh", "_right"),
             arms = !is_absent(absent, "upper_arm", "_left") && !is_absent(absent, "upper_arm", "_right");
  RoundHeads candidates(a);
  HeadsInBody body(a);
  trunk.lungs = body.lungs();
  Pair other_than;
  if (not_hips[0] && not_hips[1]) other_than = {*not_hips[0], *not_hips[1], 1};
  if (legs) find_hips(a, body, candidates, other_than, trunk);
  if (arms) find_shoulders(a, body, candidates, trunk);
  find_lone_hip(a, body, candidates, trunk);
  find_lone_shoulder(a, body, candidates, trunk);
  if (arms && !trunk.shoulder[0] && trunk.hip[0]) find_one_shoulder(a, body, candidates, trunk);
  if (!trunk.shoulder[0] && !trunk.hip[0]) find_one_side(a, body, candidates, trunk);
  if (!trunk.shoulder[0] && !trunk.hip[0]) {
    body.allow_hollow();
    if (legs) find_hips(a, body, candidates, other_than, trunk);
    if (arms) find_shoulders(a, body, candidates, trunk);
    if (!trunk.hip[0]) find_lone_hip(a, body, candidates, trunk);
    find_lone_shoulder(a, body, candidates, trunk);
  }
  const bool hips = trunk.hip[0] && trunk.hip[1], shoulders = trunk.shoulder[0] && trunk.shoulder[1];
  if (!hips && !shoulders) return trunk;
  const auto& pair = hips ? trunk.hip : trunk.shoulder;
  const Vector3d m = 0.5 * (pair[0]->centre + pair[1]->centre);
  const double end = a.grid().origin[2] + a.step() * static_cast<double>(a.grid().size[2] - 2);
  double top = end;
  if (shoulders)
    top = std::min(end, 0.5 * (trunk.shoulder[0]->centre[2] + trunk.shoulder[1]->centre[2]) + 170);
  // above the hips the sacrum lies in the middle, and the column may lean to a side from there
  if (hips)
    find_spine(a, m[0], m[2] + 35, top, 15, 0.3, trunk);
  else
    find_spine(a, m[0], a.grid().origin[2] + a.step(), top, 30, 0, trunk);
  settle_middle(a, trunk);
  settle_lone_heads(trunk);
  // references: mean hip to mean shoulder height 515 mm, hip centres 172 mm apart, shoulders 364 mm apart;
  // the longer measure is the more reliable
  if (hips && shoulders)
    trunk.scale = (0.5 * (trunk.shoulder[0]->centre[2] + trunk.shoulder[1]->centre[2]) - m[2]) / 515;
  else if (hips)
    trunk.scale = (trunk.hip[0]->centre - trunk.hip[1]->centre).norm() / 172;
  else
    trunk.scale = (trunk.shoulder[0]->centre - trunk.shoulder[1]->centre).norm() / 364;
  trunk.scale = std::clamp(trunk.scale, 0.5, 1.3);
  return trunk;
}

}  // namespace borelli
