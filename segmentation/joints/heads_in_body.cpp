#include "segmentation/joints/heads_in_body.hpp"

#include <algorithm>
#include <cmath>

#include "segmentation/grid/geodesic.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Lung is a solid region of airy tissue. Gas in gut, stomach and windpipe is emptier, and its rim of mixed
// voxels is thinner than `rim`, mm.
constexpr int emptiest_lung = -950, densest_lung = -350;
constexpr double rim = 5;
// least volume of a piece of lung, ml; stool with gas in it comes in smaller pieces
constexpr double smallest_lung = 30;

std::vector<double> lung_by_slice(const Anatomy& a) {
  const Mask airy = where(a.grid(), [&](std::size_t o) {
    return a.body.voxels[o] && a.scan.hu.voxels[o] > emptiest_lung && a.scan.hu.voxels[o] < densest_lung;
  });
  // a lung may continue beyond the scan's edge
  const Mask wide = eroded(
      where(a.grid(), [&](std::size_t o) { return airy.voxels[o] || !a.scan.seen.voxels[o]; }), rim, true);
  const double voxel = std::pow(a.step(), 3) * 1e-3;
  const Mask lungs =
      kept_regions(where(a.grid(), [&](std::size_t o) { return airy.voxels[o] && wide.voxels[o]; }), 26,
                   [&](const Region& piece, const Region&) {
                     return static_cast<double>(piece.voxels) * voxel >= smallest_lung;
                   });
  const auto slice = static_cast<std::size_t>(a.grid().size[0] * a.grid().size[1]);
  std::vector<double> lung(static_cast<std::size_t>(a.grid().size[2]), 0);
  for (std::size_t k = 0; k < lung.size(); ++k)
    for (std::size_t o = k * slice; o < (k + 1) * slice; ++o)
      if (lungs.voxels[o]) lung[k] += voxel;
  return lung;
}

struct Share {
  double bone = 0, seen = 0;
};

// A box about a point (half widths, mm): the fraction in view, and the fraction of bone in what is in view.
Share shares(const Anatomy& a, const Vector3d& centre, const Vector3d& half) {
  const Vector3d low = a.grid().index(centre - half), high = a.grid().index(centre + half);
  double bone = 0, seen = 0, all = 0;
  for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
    for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
      for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
        ++all;
        if (!a.grid().holds(i, j, k) || !a.scan.seen.at(i, j, k)) continue;
        ++seen;
        bone += a.bone.at(i, j, k);
      }
  return {seen > 0 ? bone / seen : 0, seen / all};
}

double depth_at(const Anatomy& a, const Vector3d& point) {
  const Vector3d index = a.grid().index(point);
  const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
  return a.grid().holds(i, j, k) ? a.depth.at(i, j, k) : 0;
}

}  // namespace

HeadsInBody::HeadsInBody(const Anatomy& a) : anatomy_(a), lung_(lung_by_slice(a)) {
  const auto& g = a.grid();
  const auto slice = static_cast<std::size_t>(g.size[0] * g.size[1]);
  const auto first = std::find(a.body.voxels.begin(), a.body.voxels.end(), 1);
  const auto last = std::find(a.body.voxels.rbegin(), a.body.voxels.rend(), 1);
  if (first == a.body.voxels.end()) return;
  const auto level = [&](std::ptrdiff_t offset) {
    return g.origin[2] + a.step() * static_cast<double>(static_cast<std::size_t>(offset) / slice);
  };
  low_ = level(first - a.body.voxels.begin());
  high_ = level(a.body.voxels.rend() - last - 1);
}

std::array<double, 2> HeadsInBody::lungs() const {
  constexpr double least = 300, left_out = 0.05;  // ml; fraction left out at each end
  double all = 0;
  for (const double ml : lung_) all += ml;
  std::array<double, 2> ends{0, 0};
  if (all < least) return ends;
  double sum = 0;
  for (std::size_t k = 0; k < lung_.size(); ++k) {
    const double z = anatomy_.grid().origin[2] + anatomy_.step() * static_cast<double>(k);
    if (sum < left_out * all && sum + lung_[k] >= left_out * all) ends[0] = z;
    if (sum < (1 - left_out) * all && sum + lung_[k] >= (1 - left_out) * all) ends[1] = z;
    sum += lung_[k];
  }
  return ends;
}

double HeadsInBody::lung_between(double low, double high) const {
  double sum = 0;
  for (std::size_t k = 0; k < lung_.size(); ++k) {
    const double z = anatomy_.grid().origin[2] + anatomy_.step() * static_cast<double>(k);
    if (z >= low && z < high) sum += lung_[k];
  }
  return sum;
}

bool HeadsInBody::deep_below_lungs(const Vector3d& left, const Vector3d& right) const {
  const Vector3d middle = 0.5 * (left + right);
  return depth_at(anatomy_, middle) > 30 && below_lungs(middle[2]);
}

bool HeadsInBody::near_hips(const Vector3d& left, const Vector3d& right) const {
  if (!deep_below_lungs(left, right)) return false;
  // a sacrum, or the lowest lumbar vertebrae above one that is no denser than flesh
  for (const double above : {75., 145.}) {
    const Share column =
        shares(anatomy_, 0.5 * (left + right) + Vector3d(0, 45, above), Vector3d(25, 45, 40));
    if (column.seen > 1.0 / 3 && column.bone > 0.06) return true;
  }
  return false;
}

bool HeadsInBody::below_lungs(double z) const {
  constexpr double hand = 120, most_lung = 100;  // mm, ml
  return lung_between(-1e9, z + hand) < most_lung;
}

bool HeadsInBody::vertebra_between(const FoundSphere& left, const FoundSphere& right) const {
  const Vector3d half(25, 100, 15);
  const double bone = shares(anatomy_, 0.5 * (left.centre + right.centre), half).bone * 4 * half[0] * half[1];
  constexpr double most_bone = 1200;  // mm^2; a sacrum has about 1900, coccyx and symphysis about 500
  return bone >= most_bone;
}

bool HeadsInBody::are_hips(const FoundSphere& left, const FoundSphere& right) const {
  return solid(left) && solid(right) && !vertebra_between(left, right) && on_femur(left, left_side) &&
         on_femur(right, right_side);
}

bool HeadsInBody::may_be_hips(const FoundSphere& left, const FoundSphere& right) const {
  const auto fine = [&](const FoundSphere& ball, int side) {
    return solid(ball) && (cuts(ball) ? below(ball) > 0 : on_femur(ball, side));
  };
  return !vertebra_between(left, right) && fine(left, left_side) && fine(right, right_side);
}

double HeadsInBody::below(const FoundSphere& ball) const { return ball.centre[2] - low_ - anatomy_.step(); }

bool HeadsInBody::cuts(const FoundSphere& ball, double off) const {
  constexpr double near = 29;
  return below(ball) - off < std::max(near, ball.radius + 2);
}

bool HeadsInBody::cuts_from_above(const FoundSphere& ball, double near) const {
  return high_ - ball.centre[2] < near;
}

bool HeadsInBody::solid(const FoundSphere& ball) const {
  // phantoms and real scans: .77 to 1 of a head's core is bone, .16 to .59 of a false one's
  constexpr double core = 0.7, least = 0.65;
  const Grid& g = anatomy_.grid();
  const double reach = core * ball.radius;
  const Vector3d low = g.index(ball.centre - Vector3d::Constant(reach)),
                 high = g.index(ball.centre + Vector3d::Constant(reach));
  double seen = 0, bone = 0;
  for (auto k = std::lround(low[2]); k <= std::lround(high[2]); ++k)
    for (auto j = std::lround(low[1]); j <= std::lround(high[1]); ++j)
      for (auto i = std::lround(low[0]); i <= std::lround(high[0]); ++i) {
        if (!g.holds(i, j, k) || !anatomy_.scan.seen.at(i, j, k)) continue;
        const Vector3d p = g.point(i, j, k);
        if ((p - ball.centre).norm() > reach) continue;
        ++seen;
        bone += anatomy_.bone.at(i, j, k);
      }
  return hollow_ || bone > least * seen;
}

bool HeadsInBody::on_femur(const FoundSphere& ball, int side) const {
  for (const Asked& asked : asked_)
    if (asked.side == side && asked.radius == ball.radius && asked.centre == ball.centre) return asked.leads;
  return asked_.emplace_back(Asked{ball.centre, ball.radius, side, femur_leads_on(ball, side)}).leads;
}

bool HeadsInBody::femur_leads_on(const FoundSphere& ball, int side) const {
  const Anatomy& a = anatomy_;
  constexpr double far = 120, detour = 1.3;  // mm
  const double outwards = side_sign(side);
  if (cuts(ball)) return false;
  const double reach = std::min(far, below(ball));
  // copies the bone about the sphere to a grid of its own
  const auto half = static_cast<std::int64_t>(std::ceil(far / a.step())) + 2;
  const Vector3d index = a.grid().index(ball.centre).array().round();
  Grid box = a.grid();
  box.size = {2 * half + 1, 2 * half + 1, 2 * half + 1};
  box.origin = a.grid().point(index - Vector3d::Constant(static_cast<double>(half)));
  Volume<float> cost{box, std::vector<float>(box.count(), no_path)};
  Volume<std::uint8_t> seeds{box, std::vector<std::uint8_t>(box.count(), 0)};
  const double core = 0.6 * ball.radius;
  const std::array<std::int64_t, 3> at{std::lround(index[0]) - half, std::lround(index[1]) - half,
                                       std::lround(index[2]) - half};
  const auto visit = [&](const auto& each) {
    for (std::int64_t k = 0; k < box.size[2]; ++k)
      for (std::int64_t j = 0; j < box.size[1]; ++j)
        for (std::int64_t i = 0; i < box.size[0]; ++i)
          each(box.offset(i, j, k), Vector3d(box.point(i, j, k) - ball.centre), i + at[0], j + at[1],
               k + at[2]);
  };
  visit([&](std::size_t o, const Vector3d& d, std::int64_t i, std::int64_t j, std::int64_t k) {
    if (!a.grid().holds(i, j, k) || !a.bone.at(i, j, k)) return;
    cost.voxels[o] = 1;
    seeds.voxels[o] = d.norm() < core;
  });
  const auto paths = geodesic({cost, a.threads}, seeds, false, static_cast<float>(2 * far));
  double best = 1e9;
  const double beyond = 1.3 * ball.radius;  // the neck begins here
  visit([&](std::size_t o, const Vector3d& d, std::int64_t i, std::int64_t j, std::int64_t k) {
    // as far away as is in view, downwards, and outwards like the femoral neck
    const double r = d.norm();
    if (paths.length(o) == no_path || d[2] > -0.45 * r || d[0] * outwards < 10) return;
    const std::int64_t next = i + (outwards > 0 ? 1 : -1);
    const bool at_side = r > beyond && !(a.grid().holds(next, j, k) && a.scan.seen.at(next, j, k));
    if (!at_side && std::abs(r - reach) > a.step()) return;
    best = std::min(best, (paths.length(o) + core) / d.norm());
  });
  return best < detour;
}

bool HeadsInBody::below_flank(const Vector3d& hip) const {
  constexpr double most_bone = 0.04;
  return shares(anatomy_, hip + Vector3d(0, 20, 165), Vector3d(20, 70, 20)).bone < most_bone;
}

bool HeadsInBody::cut_beside(double middle, int side) const {
  const Grid& g = anatomy_.grid();
  constexpr double much = 200e2, beside = 110;  // mm^2; mm
  std::vector<double>& edge = edge_[static_cast<std::size_t>(side)];
  if (edge.empty()) {
    edge.resize(static_cast<std::size_t>(g.size[0]), 0);
    const std::ptrdiff_t inwards = side_sign(side) > 0 ? -1 : 1;
    for (std::int64_t row = 0; row < g.size[1] * g.size[2]; ++row) {
      const std::uint8_t* const body = anatomy_.body.voxels.data() + row * g.size[0];
      const std::uint8_t* const next = anatomy_.scan.seen.voxels.data() + row * g.size[0] + inwards;
      for (std::size_t i = 1; i + 1 < edge.size(); ++i)
        if (body[i] && !next[i]) edge[i] += anatomy_.step() * anatomy_.step();
    }
  }
  double area = 0;
  for (std::size_t i = 0; i < edge.size(); ++i)
    if (std::abs(g.point(Vector3d(static_cast<double>(i), 0, 0))[0] - middle) <= beside) area += edge[i];
  return area > much;
}

bool HeadsInBody::at_shoulder(const Vector3d& head) const {
  constexpr double near = 20, far = 60, above = 100;  // mm
  constexpr double one_lung = smallest_lung / 2;
  return lung_between(head[2] - far, head[2] - near) >= one_lung &&
         lung_between(head[2] + above, 1e9) < one_lung;
}

bool HeadsInBody::at_shoulders(const Vector3d& left, const Vector3d& right) const {
  const Anatomy& a = anatomy_;
  const Vector3d middle = 0.5 * (left + right);
  if (depth_at(a, middle) <= 20 || shares(a, middle + Vector3d(0, 20, 0), Vector3d(30, 60, 40)).bone <= 0.03)
    return false;
  const double z = middle[2], acromion = 35;
  if (std::max(left[2], right[2]) + acromion > high_) return false;
  constexpr double near = 20, far = 60, ended = 100, edge = 12;  // mm
  // ml of lung per mm of height, over the part of a stretch that is in view
  const auto section = [&](double low, double high) {
    low = std::max(low, low_), high = std::min(high, high_ + a.step());
    return high - low > 0.5 * a.step() ? lung_between(low, high) / (high - low) : 0;
  };
  // at the scan's edge the body mask ends a passage's width before air
  const double top = std::min(z + far, high_ - edge);
  const double below = section(z - far, z - near),
               above = section(std::min(z + near, top - 2 * a.step()), top);
  return below * (far - near) >= smallest_lung && above < 0.6 * below &&
         lung_between(z + ended, 1e9) < smallest_lung;
}

}  // namespace borelli
