#include "segmentation/labelling/touching_flesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "segmentation/body/body_mask.hpp"
#include "segmentation/body/tissues.hpp"
#include "segmentation/labelling/seen_border.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// the thickest fat considered: of an arm, and of what it touches, mm
constexpr double most_of_arm = 40, most_of_other = 60;
// epidermis and dermis, which pressure does not thin, mm (Laurent et al. 2007, Vaccine 25:6423: 1.5 to 2.5 mm
// from thigh to shoulder)
constexpr double skin = 2;
// midway between fat and air: the CT number at a blurred edge
constexpr double blurred_skin = -550;
// range of the free skin that informs the fat thickness at a point: standard deviation of the weight, and
// limit, mm
constexpr double near = 25, farthest = 75;

// 1, 2: the arm of a label; 0: not an arm
constexpr int arm_of(int label) {
  if (label < part_label("upper_arm_left") || label > part_label("hand_right")) return 0;
  return label % 2 == part_label("upper_arm_left") % 2 ? 1 : 2;
}

struct Box {
  std::array<std::int64_t, 3> low{1 << 30, 1 << 30, 1 << 30}, high{-1, -1, -1};
  bool empty() const { return high[0] < low[0]; }
  void add(std::int64_t i, std::int64_t j, std::int64_t k) {
    const std::array<std::int64_t, 3> at{i, j, k};
    for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], at[c]), high[c] = std::max(high[c], at[c]);
  }
  Box grown(std::int64_t by, const Grid& g) const {
    Box out = *this;
    for (std::size_t c = 0; c < 3; ++c) {
      out.low[c] = std::max<std::int64_t>(0, out.low[c] - by);
      out.high[c] = std::min(g.size[c] - 1, out.high[c] + by);
    }
    return out;
  }
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::int64_t k = low[2]; k <= high[2]; ++k)
      for (std::int64_t j = low[1]; j <= high[1]; ++j)
        for (std::int64_t i = low[0]; i <= high[0]; ++i) visit(i, j, k);
  }
};

// Points sorted into cells of some centimetres, for search by position.
template <class Item>
class Cells {
 public:
  Cells(const Vector3d& low, const Vector3d& high, double width) : low_(low), width_(width) {
    for (int c = 0; c < 3; ++c)
      size_[static_cast<std::size_t>(c)] =
          static_cast<std::int64_t>(std::max(0.0, high[c] - low[c]) / width) + 1;
    cells_.resize(static_cast<std::size_t>(size_[0] * size_[1] * size_[2]));
  }
  void add(const Vector3d& point, const Item& item) {
    std::array<std::int64_t, 3> at{};
    for (std::size_t c = 0; c < 3; ++c) at[c] = std::clamp<std::int64_t>(cell(point, c), 0, size_[c] - 1);
    cells_[offset(at[0], at[1], at[2])].push_back({point, item});
  }
  template <class Visit>
  void within(const Vector3d& point, double reach, const Visit& visit) const {
    std::array<std::int64_t, 3> low{}, high{};
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::clamp<std::int64_t>(cell(point - Vector3d::Constant(reach), c), 0, size_[c] - 1);
      high[c] = std::clamp<std::int64_t>(cell(point + Vector3d::Constant(reach), c), 0, size_[c] - 1);
    }
    for (auto k = low[2]; k <= high[2]; ++k)
      for (auto j = low[1]; j <= high[1]; ++j)
        for (auto i = low[0]; i <= high[0]; ++i)
          for (const auto& [p, item] : cells_[offset(i, j, k)])
            if ((p - point).squaredNorm() <= reach * reach) visit(p, item);
  }

  /// Visits at least the items within `reach` mm of a point, in rings of cells around it. `visit` returns the reach
  /// from then on.
  template <class Visit>
  void visit_rings(const Vector3d& point, double reach, const Visit& visit) const {
    std::array<std::int64_t, 3> at{};
    double inner = width_;  // distance from the point to the nearest face of its cell
    for (std::size_t c = 0; c < 3; ++c) {
      at[c] = cell(point, c);
      const auto n = static_cast<Eigen::Index>(c);
      const double in = point[n] - low_[n] - width_ * static_cast<double>(at[c]);
      inner = std::min({inner, in, width_ - in});
    }
    for (std::int64_t ring = 0; ring == 0 || width_ * static_cast<double>(ring - 1) + inner < reach; ++ring)
      for (auto k = std::max<std::int64_t>(0, at[2] - ring); k <= std::min(size_[2] - 1, at[2] + ring); ++k)
        for (auto j = std::max<std::int64_t>(0, at[1] - ring); j <= std::min(size_[1] - 1, at[1] + ring);
             ++j) {
          const bool whole_row = std::abs(k - at[2]) == ring || std::abs(j - at[1]) == ring || ring == 0;
          for (std::int64_t i = at[0] - ring; i <= at[0] + ring; i += whole_row ? 1 : 2 * ring)
            if (i >= 0 && i < size_[0])
              for (const auto& [p, item] : cells_[offset(i, j, k)]) reach = visit(p, item);
        }
  }

 private:
  std::int64_t cell(const Vector3d& p, std::size_t c) const {
    const auto n = static_cast<Eigen::Index>(c);
    return static_cast<std::int64_t>(std::floor((p[n] - low_[n]) / width_));
  }
  std::size_t offset(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * size_[1] + j) * size_[0] + i);
  }
  Vector3d low_;
  double width_;
  std::array<std::int64_t, 3> size_{};
  std::vector<std::vector<std::pair<Vector3d, Item>>> cells_;
};

// The surface of lean flesh: points between voxels, each with its owner.
using Surface = Cells<std::uint8_t>;

struct Nearest {
  double distance;
  std::uint8_t label;
  Vector3d point;
};

// the nearest surface point whose owner satisfies `counts`; empty if none within `reach` mm
template <class Counts>
std::optional<Nearest> nearest(const Surface& surface, const Vector3d& point, double reach,
                               const Counts& counts) {
  std::optional<Nearest> best;
  double within = reach;
  surface.visit_rings(point, reach, [&](const Vector3d& p, std::uint8_t label) {
    const double d = (p - point).squaredNorm();
    if (d <= within * within && counts(label)) within = std::sqrt(d), best = Nearest{within, label, p};
    return within;
  });
  return best;
}

// The first surface's share of the gap between two lean surfaces, mm. `first`, `second`: fat thickness of
// each on free skin, mm.
double border(double gap, double first, double second) {
  const double pressed = first + second - gap;
  if (pressed <= 0) return gap * first / (first + second);
  const double hard = std::min(skin, first), hard_second = std::min(skin, second);
  const double soft = first - hard, soft_second = second - hard_second;
  if (pressed >= soft + soft_second) return gap * hard / (hard + hard_second);
  return first - pressed * soft / (soft + soft_second);
}

}  // namespace

LeanFlesh lean_flesh(const Anatomy& a) {
  const auto& g = a.grid();
  const double thin = std::max(3.0, a.step()) * 1.01;  // half of the least thickness
  const Mask dense = where(g, [&](std::size_t o) {
    return a.body.voxels[o] && (a.bone.voxels[o] || a.scan.hu.voxels[o] >= fat_to_hu);
  });
  const Mask thick = eroded(dense, thin, true);
  const Mask near_core =
      dilated(where(g, [&](std::size_t o) { return a.bone.voxels[o] || thick.voxels[o]; }), thin);
  LeanFlesh lean;
  lean.mask = where(g, [&](std::size_t o) { return dense.voxels[o] && near_core.voxels[o]; });
  lean.depth = distance_to(complement(lean.mask), 200, false, a.threads);
  return lean;
}

namespace {

// The lean surfaces of an arm and of all other parts, and the fat thickness below the free skin of either,
// near their contact.
class FleshContact {
 public:
  FleshContact(const Anatomy& a, const Mask& lean, const Volume<std::uint8_t>& owner, int arm)
      : a_(a),
        lean_(lean),
        owner_(owner),
        arm_(arm),
        profile_(*a.source),
        disputed_(disputed(a, lean, owner, arm)) {
    const auto& g = a.grid();
    Box{{0, 0, 0}, {g.size[0] - 1, g.size[1] - 1, g.size[2] - 1}}.each(
        [&](std::int64_t i, std::int64_t j, std::int64_t k) {
          if (disputed_.at(i, j, k)) box_.add(i, j, k);
        });
    if (!box_.empty()) measure();
  }

  const Box& box() const { return box_; }
  bool is_disputed(std::size_t o) const { return disputed_.voxels[o] != 0; }

  // The owner of a point in fat: the part of the nearest lean flesh on its side of the border. Empty if lean
  // flesh or free skin of either side is not near.
  std::optional<std::uint8_t> owner_of(const Vector3d& p, std::optional<double> fat_of_arm,
                                       std::optional<double> fat_of_other) const {
    const auto to_arm = nearest(*surface_, p, most_of_arm, [&](std::uint8_t l) { return own(l); });
    if (!to_arm) return std::nullopt;
    const auto to_other = nearest(*surface_, p, most_of_other, [&](std::uint8_t l) { return !own(l); });
    if (!to_other) return std::nullopt;
    const double gap = to_arm->distance + to_other->distance;
    const double expected = fat_of_arm && fat_of_other ? border(gap, *fat_of_arm, *fat_of_other) : 0.5 * gap;
    const auto seen = seen_border(profile_, to_arm->point, p, to_other->point, expected);
    if (!seen && (!fat_of_arm || !fat_of_other)) return std::nullopt;
    const bool arms = to_arm->distance < seen.value_or(expected);
    return arms ? to_arm->label : to_other->label;
  }

  // mean fat thickness below free skin around a point, mm
  std::optional<double> fat_at(const Vector3d& p, bool of_arm) const {
    double sum = 0, weight = 0;
    (of_arm ? *of_arm_ : *of_other_).within(p, farthest, [&](const Vector3d& q, float thickness) {
      const double w = std::exp(-0.5 * (p - q).squaredNorm() / (near * near));
      sum += w * static_cast<double>(thickness);
      weight += w;
    });
    if (weight < 1) return std::nullopt;
    return sum / weight;
  }

 private:
  bool own(std::uint8_t label) const { return arm_of(label) == arm_; }

  // fat within its greatest thickness (most_of_arm) of contact between flesh of the arm and other flesh
  static Mask disputed(const Anatomy& a, const Mask& lean, const Volume<std::uint8_t>& owner, int arm) {
    const auto& g = a.grid();
    Mask faces{g, std::vector<std::uint8_t>(g.count(), 0)};
    in_turns(g.size[2], a.threads, [&](std::int64_t k0, std::int64_t k1) {
      for (std::int64_t k = std::max<std::int64_t>(1, k0); k < std::min(k1, g.size[2] - 1); ++k)
        for (std::int64_t j = 1; j + 1 < g.size[1]; ++j)
          for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
            if (arm_of(owner.at(i, j, k)) != arm) continue;
            const std::array<std::uint8_t, 6> around{owner.at(i - 1, j, k), owner.at(i + 1, j, k),
                                                     owner.at(i, j - 1, k), owner.at(i, j + 1, k),
                                                     owner.at(i, j, k - 1), owner.at(i, j, k + 1)};
            faces.at(i, j, k) =
                std::any_of(around.begin(), around.end(), [&](int l) { return l != 0 && arm_of(l) != arm; });
          }
    });
    const Mask near_faces = dilated(faces, std::nextafter(static_cast<float>(most_of_arm), 0.0F));
    return where(g, [&](std::size_t o) {
      return near_faces.voxels[o] && owner.voxels[o] && a.body.voxels[o] && !lean.voxels[o] &&
             a.scan.hu.voxels[o] >= lung_to_hu;
    });
  }

  // locates lean and skin surfaces where the CT number crosses their limits between two voxels
  void measure() {
    const auto& g = a_.grid();
    const double step = a_.step();
    const Box box = box_.grown(static_cast<std::int64_t>(farthest / step) + 1, g);
    const Vector3d low = g.point(box.low[0], box.low[1], box.low[2]),
                   high = g.point(box.high[0], box.high[1], box.high[2]);
    const Vector3d margin = Vector3d::Constant(step);  // surfaces lie up to a step outside the box
    surface_.emplace(low - margin, high + margin, 8);
    of_arm_.emplace(low, high, near);
    of_other_.emplace(low, high, near);
    std::vector<std::pair<Vector3d, bool>> skin_points;
    box.each([&](std::int64_t i, std::int64_t j, std::int64_t k) {
      const std::size_t o = g.offset(i, j, k);
      if (!a_.body.voxels[o] || !owner_.voxels[o]) return;
      const double here = a_.scan.hu.voxels[o];
      const std::array<std::array<std::int64_t, 3>, 6> around{
          {{i - 1, j, k}, {i + 1, j, k}, {i, j - 1, k}, {i, j + 1, k}, {i, j, k - 1}, {i, j, k + 1}}};
      for (const auto& n : around) {
        if (!g.holds(n[0], n[1], n[2])) continue;
        const std::size_t q = g.offset(n[0], n[1], n[2]);
        if (!a_.scan.seen.voxels[q]) continue;
        const double there = a_.scan.hu.voxels[q];
        const auto passes = [&](double limit) {
          const double t = there < limit && limit < here ? (here - limit) / (here - there) : 0.5;
          return Vector3d(g.point(i, j, k) + t * step * Vector3d(n[0] - i, n[1] - j, n[2] - k));
        };
        const bool free = !a_.body.voxels[q] && there < skin_edge_hu;
        if (free) skin_points.emplace_back(passes(blurred_skin), own(owner_.voxels[o]));
        if (lean_.voxels[o] && !lean_.voxels[q])
          surface_->add(passes(free ? blurred_skin : fat_to_hu), owner_.voxels[o]);
      }
    });
    constexpr float none = -1;
    std::vector<float> thickness(skin_points.size(), none);
    in_turns(std::ssize(skin_points), a_.threads, [&](std::int64_t first, std::int64_t last) {
      for (auto n = static_cast<std::size_t>(first); n < static_cast<std::size_t>(last); ++n) {
        const auto& [p, arms] = skin_points[n];
        const auto same = nearest(*surface_, p, arms ? most_of_arm : most_of_other,
                                  [&, mine = arms](std::uint8_t l) { return own(l) == mine; });
        if (!same) continue;
        // near a crevice the skin may belong to the other side
        if (!nearest(*surface_, p, same->distance + 2 * step,
                     [&, mine = arms](std::uint8_t l) { return own(l) != mine; }))
          thickness[n] = static_cast<float>(same->distance);
      }
    });
    for (std::size_t n = 0; n < skin_points.size(); ++n)
      if (thickness[n] != none)
        (skin_points[n].second ? *of_arm_ : *of_other_).add(skin_points[n].first, thickness[n]);
  }

  const Anatomy& a_;
  const Mask& lean_;
  const Volume<std::uint8_t>& owner_;
  int arm_;
  ScanProfile profile_;
  Mask disputed_;
  Box box_;
  std::optional<Surface> surface_;
  std::optional<Cells<float>> of_arm_, of_other_;
};

// Majority filter: a disputed voxel takes the side of most of its neighbours. Corrects single voxels that
// noise or a vessel put on the wrong side.
void smooth_border(const Anatomy& a, const FleshContact& contact, int arm, Volume<std::uint8_t>& owner) {
  const auto& g = a.grid();
  const Volume<std::uint8_t> before = owner;
  contact.box().each([&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const std::size_t o = g.offset(i, j, k);
    if (!contact.is_disputed(o)) return;
    std::array<int, parts.size()> count{};
    int same = 0, other = 0;
    const bool arms = arm_of(before.voxels[o]) == arm;
    for (std::int64_t c = k - 1; c <= k + 1; ++c)
      for (std::int64_t b = j - 1; b <= j + 1; ++b)
        for (std::int64_t l = i - 1; l <= i + 1; ++l) {
          if (!g.holds(l, b, c) || !a.body.at(l, b, c)) continue;
          const auto label = before.at(l, b, c);
          if (label == 0) continue;
          ++((arm_of(label) == arm) == arms ? same : other);
          ++count[label];
        }
    if (other <= same) return;
    int best = 0;
    for (int label = 1; label < static_cast<int>(parts.size()); ++label)
      if ((arm_of(label) == arm) != arms &&
          count[static_cast<std::size_t>(label)] > count[static_cast<std::size_t>(best)])
        best = label;
    owner.voxels[o] = static_cast<std::uint8_t>(best);
  });
}

}  // namespace

void part_touching_flesh(const Anatomy& a, const Mask& lean, Volume<std::uint8_t>& owner) {
  const auto& g = a.grid();
  for (const int arm : {1, 2}) {
    const Volume<std::uint8_t> before = owner;
    const FleshContact contact(a, lean, before, arm);
    const Box& box = contact.box();
    if (box.empty()) continue;
    // fat thickness hardly changes over this many voxels
    constexpr std::int64_t block = 4;
    const auto blocks = [&](std::size_t c) { return (box.high[c] - box.low[c]) / block + 1; };
    in_turns(blocks(2), a.threads, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t w = first; w < last; ++w)
        for (std::int64_t v = 0; v < blocks(1); ++v)
          for (std::int64_t u = 0; u < blocks(0); ++u) {
            const std::array<std::int64_t, 3> low{box.low[0] + block * u, box.low[1] + block * v,
                                                  box.low[2] + block * w};
            Box part{low, low};
            for (std::size_t c = 0; c < 3; ++c) part.high[c] = std::min(box.high[c], low[c] + block - 1);
            std::optional<double> of_arm, of_other;
            bool asked = false;
            part.each([&](std::int64_t i, std::int64_t j, std::int64_t k) {
              const std::size_t o = g.offset(i, j, k);
              if (!contact.is_disputed(o)) return;
              if (!asked) {
                const Vector3d middle = 0.5 * (g.point(part.low[0], part.low[1], part.low[2]) +
                                               g.point(part.high[0], part.high[1], part.high[2]));
                of_arm = contact.fat_at(middle, true);
                of_other = contact.fat_at(middle, false);
                asked = true;
              }
              const auto found = contact.owner_of(g.point(i, j, k), of_arm, of_other);
              if (found && (arm_of(*found) == arm) != (arm_of(before.voxels[o]) == arm))
                owner.voxels[o] = *found;
            });
          }
    });
    smooth_border(a, contact, arm, owner);
  }
}

}  // namespace borelli
