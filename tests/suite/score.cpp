#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "segmentation/labelling/edge_contact.hpp"
#include "tests/suite/part_masses.hpp"
#include "tests/suite/phantom_suite.hpp"

namespace borelli::suite {
namespace {

using Eigen::Vector3d;

constexpr double hip_within = 1.5, joint_within = 3, mass_within = 0.03;  // mm, mm, share
constexpr double not_found = 999;
// shares of a part's exact volume, which voxels of 2 and 5 mm give to 1 %
constexpr double whole_from = 0.98, sliver_below = 0.05, absent_below = 0.002;
// a joint nearer than this to the scan's end need not be found, because bone on both its sides is not in view
constexpr double from_end = 45;  // mm
// below it `borelli segment` warns
constexpr double warned_below = 0.5;

// Whether a ball around a point is entirely in the scan.
bool well_within(const Case& asked, const Scan& scan, const Vector3d& point) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const Vector3d p = point + sign * from_end * Vector3d::Unit(axis);
      const bool cropped =
          (p - asked.grid.crop_low).minCoeff() < 0 || (asked.grid.crop_high - p).minCoeff() < 0;
      if (cropped) return false;
      const Vector3d index = scan.grey.grid.index(p);
      const auto i = std::lround(index[0]), j = std::lround(index[1]), k = std::lround(index[2]);
      if (scan.grey.grid.holds(i, j, k) && scan.grey.at(i, j, k) == -2000) return false;
    }
  return true;
}

// Area in which each part's exact labels meet the scan's outer faces, mm^2, by part.
std::array<double, parts.size()> sections_at_faces(const LabelMap& labels) {
  std::array<double, parts.size()> area{};
  const Grid& g = labels.grid;
  const Vector3d edge = g.spacing();
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::array<std::int64_t, 3> at{i, j, k};
        for (std::size_t c = 0; c < 3; ++c)
          if (at[c] == 0 || at[c] + 1 == g.size[c])
            area[labels.at(i, j, k)] += edge.prod() / edge[static_cast<Eigen::Index>(c)];
      }
  return area;
}

}  // namespace

Score score(const Case& asked) {
  const auto body = build_phantom(asked.body);
  if (!body) throw std::runtime_error(asked.name + ": " + body.error().message());
  const Scan scan = voxelise(*body, phantom_grid(*body, asked.grid, asked.scan.table), asked.scan);
  const auto begin = std::chrono::steady_clock::now();
  const auto found = segment(scan.grey);
  if (!found) throw std::runtime_error(asked.name + ": " + found.error().message());
  Score out;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  std::array<double, parts.size()> both{}, exact{}, mine{};
  for (std::size_t o = 0; o < scan.labels.voxels.size(); ++o) {
    const auto e = scan.labels.voxels[o], m = found->labels.voxels[o];
    ++exact[e], ++mine[m];
    both[e] += e == m;
  }
  const auto miss = [&](const std::string& what, std::size_t part, bool told) {
    out.misses.push_back(what);
    const PartFinding& finding = found->part[part];
    if (!told && finding.coverage != Coverage::absent && finding.confidence >= warned_below)
      out.silent.push_back(what);
  };
  const auto mass = part_masses(found->labels, scan.grey);
  const double voxel = scan.labels.grid.voxel_volume() * 1e-9;
  const auto section = sections_at_faces(scan.labels);
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const std::string name(parts[n].name);
    const double held = exact[n] * voxel / body->volume[n];
    out.judged[n] = held >= sliver_below;
    out.whole[n] = held > whole_from;
    const Coverage should = out.whole[n]          ? Coverage::whole
                            : held > absent_below ? Coverage::cut
                                                  : Coverage::absent;
    // a sliver of a part need not be labelled, but may not be called whole
    const bool sliver = !out.judged[n] && found->part[n].coverage != Coverage::whole;
    // a nearly complete part may be called cut, as may one that meets the scan's end, even if its flesh ends
    // there, which the scan cannot show
    const bool nearly =
        (held < 0.995 || section[n] > cut_section) && found->part[n].coverage == Coverage::cut;
    if (found->part[n].coverage != should && !sliver && !nearly)
      miss(std::string(name_of(found->part[n].coverage)) + " " + name, n,
           found->part[n].coverage != Coverage::whole);
    out.dice[n] = exact[n] + mine[n] > 0 ? 2 * both[n] / (exact[n] + mine[n]) : 1;
    if (!out.judged[n]) continue;
    const bool touches =
        std::find(asked.touching.begin(), asked.touching.end(), name) != asked.touching.end();
    if (out.dice[n] < (touches || is_end(name) ? 0.90 : 0.95)) miss("dice " + name, n, false);
    if (!out.whole[n]) continue;
    out.mass_error[n] = mass[n] / body->exact[n].mass - 1;
    if (std::abs(out.mass_error[n]) > mass_within) miss("mass " + name, n, false);
  }
  for (std::size_t n = 1; n < parts.size(); ++n) {
    if (parts[n].joint.empty()) continue;
    const std::string joint(parts[n].joint);
    const Vector3d exact_centre = body->landmarks.at(joint).point;
    if (!well_within(asked, scan, exact_centre)) continue;
    const auto it = found->landmarks.find(joint);
    const double error = it == found->landmarks.end() ? not_found : (it->second.point - exact_centre).norm();
    out.joint_error[joint] = error;
    if (error <= (joint.starts_with("hip") ? hip_within : joint_within)) continue;
    // a deviation of a third of the error or more reports it
    const bool told = it == found->landmarks.end() || error < 3 * it->second.deviation;
    miss("joint " + joint, n, told);
  }
  std::sort(out.misses.begin(), out.misses.end());
  std::sort(out.silent.begin(), out.silent.end());
  return out;
}

}  // namespace borelli::suite
