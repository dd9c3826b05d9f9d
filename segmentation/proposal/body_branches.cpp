#include "segmentation/proposal/body_branches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "segmentation/grid/geodesic.hpp"

namespace borelli {
namespace {

std::array<std::int64_t, 3> index_of(const Grid& g, std::size_t o) {
  const auto n = static_cast<std::int64_t>(o);
  return {n % g.size[0], n / g.size[0] % g.size[1], n / (g.size[0] * g.size[1])};
}

// The deep flesh nearest to the body's centre. The weights grow with depth, so that limbs hardly shift the
// centre.
std::size_t middle_of(const CoarseBody& b) {
  double sum = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  int deepest = 0;
  for (const std::uint32_t o : b.places) {
    const double weight = std::pow(static_cast<double>(b.depth[o]), 3);
    const auto [i, j, k] = index_of(b.grid(), o);
    centre +=
        weight * Eigen::Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    sum += weight;
    deepest = std::max<int>(deepest, b.depth[o]);
  }
  if (sum > 0) centre /= sum;
  std::size_t best = b.places.front();
  double nearest = 1e300;
  for (const std::uint32_t o : b.places) {
    if (2 * b.depth[o] < deepest) continue;
    const auto [i, j, k] = index_of(b.grid(), o);
    const Eigen::Vector3d p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
    if (const double square = (p - centre).squaredNorm(); square < nearest) nearest = square, best = o;
  }
  return best;
}

std::vector<std::uint16_t> distances_from(const CoarseBody& b, std::size_t start) {
  Volume<std::uint8_t> seeds{b.grid(), std::vector<std::uint8_t>(b.grid().count())};
  seeds.voxels[start] = 1;
  Geodesic paths =
      geodesic(Places(b.grid(), b.threads, [&](std::size_t o) { return b.body.voxels[o] ? 1.0F : no_path; }),
               seeds, false);
  std::vector<std::uint16_t> out(b.grid().count(), no_distance);
  for (const std::uint32_t o : b.places)
    if (const float length = paths.length(o); length < static_cast<float>(no_distance))
      out[o] = static_cast<std::uint16_t>(length);
  return out;
}

// Pieces that no path from the centre reaches keep the initial values.
void measure_ends(const CoarseBody& b, BodyBranches& out) {
  constexpr int most_ends = 5;
  constexpr int least_apart = 150;  // mm: a point nearer than this to an end is no further end
  const std::size_t count = b.grid().count();
  out.nearest_end.assign(count, no_distance);
  out.next_end.assign(count, no_distance);
  out.farthest_end.assign(count, 0);
  for (int n = 0; n < most_ends; ++n) {
    std::size_t end = 0;
    int farthest = -1;
    for (const std::uint32_t o : b.places) {
      if (out.from_middle[o] >= no_distance) continue;
      const int here = n == 0 ? out.from_middle[o] : std::min(out.nearest_end[o], out.from_middle[o]);
      if (here > farthest) farthest = here, end = o;
    }
    if (farthest < 0 || (n > 0 && farthest < least_apart)) break;
    const auto distance = distances_from(b, end);
    for (const std::uint32_t o : b.places) {
      const std::uint16_t d = distance[o];
      if (d >= no_distance) continue;
      if (d < out.nearest_end[o])
        out.next_end[o] = out.nearest_end[o], out.nearest_end[o] = d;
      else
        out.next_end[o] = std::min(out.next_end[o], d);
      out.farthest_end[o] = std::max(out.farthest_end[o], d);
    }
  }
}

// calls visit(neighbour's offset) for the 6 neighbours by faces
template <class Visit>
void for_faces(const Grid& g, std::size_t o, const Visit& visit) {
  const auto [i, j, k] = index_of(g, o);
  const std::int64_t row = g.size[0], slice = g.size[0] * g.size[1];
  const auto at = static_cast<std::int64_t>(o);
  if (i > 0) visit(static_cast<std::size_t>(at - 1));
  if (i + 1 < g.size[0]) visit(static_cast<std::size_t>(at + 1));
  if (j > 0) visit(static_cast<std::size_t>(at - row));
  if (j + 1 < g.size[1]) visit(static_cast<std::size_t>(at + row));
  if (k > 0) visit(static_cast<std::size_t>(at - slice));
  if (k + 1 < g.size[2]) visit(static_cast<std::size_t>(at + slice));
}

// sections in the order of their bands
void find_sections(const CoarseBody& b, BodyBranches& out) {
  const auto band_of = [&](std::uint32_t o) {
    return static_cast<std::int32_t>(out.from_middle[o] / band_width);
  };
  std::vector<std::uint32_t> order = b.places;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t l, std::uint32_t r) { return band_of(l) < band_of(r); });
  out.section.assign(b.grid().count(), -1);
  std::vector<std::uint32_t> open;
  for (const std::uint32_t first : order) {
    if (out.section[first] >= 0) continue;
    const auto own = static_cast<std::int32_t>(out.sections.size());
    BodySection section;
    section.band = section.last_band = band_of(first);
    open.push_back(first), out.section[first] = own;
    while (!open.empty()) {
      const std::uint32_t o = open.back();
      open.pop_back();
      ++section.voxels;
      section.bone += b.bone.voxels[o];
      section.cut |= at_scan_end(b, o);
      for_faces(b.grid(), o, [&](std::size_t n) {
        if (!b.body.voxels[n] || out.section[n] >= 0) return;
        if (band_of(static_cast<std::uint32_t>(n)) != section.band) return;
        out.section[n] = own;
        open.push_back(static_cast<std::uint32_t>(n));
      });
    }
    section.voxels_beyond = section.voxels, section.bone_beyond = section.bone;
    out.sections.push_back(section);
  }
}

void hang_sections(const CoarseBody& b, BodyBranches& out) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> faces;  // (section, one of the band before)
  for (const std::uint32_t o : b.places)
    for_faces(b.grid(), o, [&](std::size_t n) {
      const std::int32_t own = out.section[o], other = out.section[n];
      if (other < 0 || other == own) return;
      if (out.sections[static_cast<std::size_t>(other)].band <
          out.sections[static_cast<std::size_t>(own)].band)
        ++faces[{own, other}];
    });
  std::vector<int> most(out.sections.size(), 0);
  for (const auto& [pair, count] : faces) {
    const auto own = static_cast<std::size_t>(pair.first);
    if (count > most[own]) most[own] = count, out.sections[own].parent = pair.second;
  }
  for (std::size_t n = out.sections.size(); n-- > 0;) {
    const BodySection& section = out.sections[n];
    if (section.parent < 0) continue;
    BodySection& parent = out.sections[static_cast<std::size_t>(section.parent)];
    parent.voxels_beyond += section.voxels_beyond, parent.bone_beyond += section.bone_beyond;
    parent.last_band = std::max(parent.last_band, section.last_band);
    parent.cut |= section.cut;
    if (parent.main_child < 0 ||
        out.sections[static_cast<std::size_t>(parent.main_child)].voxels_beyond < section.voxels_beyond)
      parent.main_child = static_cast<std::int32_t>(n);
  }
}

}  // namespace

BodyBranches body_branches(const CoarseBody& b) {
  BodyBranches out;
  out.from_middle.assign(b.grid().count(), no_distance);
  if (b.places.empty()) return out;
  out.from_middle = distances_from(b, middle_of(b));
  measure_ends(b, out);
  find_sections(b, out);
  hang_sections(b, out);
  return out;
}

}  // namespace borelli
