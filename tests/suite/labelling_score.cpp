#include "tests/suite/labelling_score.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <stdexcept>

#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/nearest_whole.hpp"

namespace borelli::suite {
namespace {

int limb_of(int part) {
  const int c = voxel_class(part);
  if (c < 0) return -1;
  const BodyRegion region = region_of(static_cast<std::size_t>(c));
  if (!is_limb(region)) return static_cast<int>(region);
  const bool right = parts[static_cast<std::size_t>(part)].name.ends_with("_right");
  return (region == BodyRegion::arm ? 2 : 4) + (right ? 1 : 0);
}

std::vector<std::uint8_t> truth_of(const CoarseBody& b, const Volume<std::uint8_t>& exact) {
  const Grid& g = b.grid();
  std::vector<std::uint8_t> out(b.places.size(), 0);
  for (std::size_t n = 0; n < b.places.size(); ++n) {
    const auto o = static_cast<std::int64_t>(b.places[n]);
    const Eigen::Vector3d index =
        exact.grid.index(g.point(o % g.size[0], o / g.size[0] % g.size[1], o / (g.size[0] * g.size[1])));
    const auto i = nearest_whole(index[0]), j = nearest_whole(index[1]), k = nearest_whole(index[2]);
    if (exact.grid.holds(i, j, k)) out[n] = exact.at(i, j, k);
  }
  return out;
}

// Dice of two labellings, by label; -1 where neither has it
template <std::size_t count>
std::array<double, count> dice_of(const std::vector<int>& found, const std::vector<int>& exact) {
  std::array<double, count> both{}, all{}, out{};
  for (std::size_t n = 0; n < found.size(); ++n) {
    if (exact[n] < 0) continue;
    if (found[n] == exact[n]) both[static_cast<std::size_t>(exact[n])] += 2;
    ++all[static_cast<std::size_t>(exact[n])];
    if (found[n] >= 0) ++all[static_cast<std::size_t>(found[n])];
  }
  for (std::size_t c = 0; c < count; ++c) out[c] = all[c] > 0 ? both[c] / all[c] : -1;
  return out;
}

// middle of the bone where two parts meet, by joint name
std::map<std::string, Eigen::Vector3d> true_joints(const CoarseBody& b,
                                                   const std::vector<std::uint8_t>& exact) {
  const Grid& g = b.grid();
  std::vector<std::uint8_t> at(g.count(), 0);
  for (std::size_t n = 0; n < b.places.size(); ++n) at[b.places[n]] = exact[n];
  std::map<int, std::pair<Eigen::Vector3d, double>> sums;
  for (std::int64_t k = 1; k + 1 < g.size[2]; ++k)
    for (std::int64_t j = 1; j + 1 < g.size[1]; ++j)
      for (std::int64_t i = 1; i + 1 < g.size[0]; ++i) {
        const std::uint8_t own = at[g.offset(i, j, k)];
        if (own < 5 || !b.bone.at(i, j, k)) continue;
        const std::string_view parent = parts[own].parent;
        for (int c = 0; c < 6; ++c) {
          const int step = c % 2 == 0 ? 1 : -1, axis = c / 2;
          const std::int64_t x = i + (axis == 0 ? step : 0), y = j + (axis == 1 ? step : 0),
                             z = k + (axis == 2 ? step : 0);
          const std::uint8_t other = at[g.offset(x, y, z)];
          if (!other || parts[other].name != parent || !b.bone.at(x, y, z)) continue;
          auto& [sum, count] = sums.try_emplace(own, Eigen::Vector3d::Zero(), 0).first->second;
          sum += 0.5 * (g.point(i, j, k) + g.point(x, y, z)), ++count;
        }
      }
  std::map<std::string, Eigen::Vector3d> out;
  for (const auto& [part, sum] : sums)
    if (sum.second >= 4)
      out[std::string(parts[static_cast<std::size_t>(part)].joint)] = sum.first / sum.second;
  return out;
}

void calibrate(const ClassProbabilities& probabilities, std::size_t n, int region, LabellingScore& out) {
  std::array<double, 4> shares{};
  for (std::size_t c = 0; c < voxel_class_count; ++c)
    shares[static_cast<std::size_t>(region_of(c))] += probabilities.of(n)[c] / 255.0;
  const auto best = std::max_element(shares.begin(), shares.end()) - shares.begin();
  const double most = shares[static_cast<std::size_t>(best)];
  const auto bin = static_cast<std::size_t>(std::clamp((most - 0.2) * 10, 0.0, 7.9));
  ++out.calibration.voxels[bin];
  out.calibration.right[bin] += best == region;
  out.right_region += best == region;
}

}  // namespace

LabellingScore score_labelling(const LabelledScan& scan, const Forest& forest) {
  const Anatomy anatomy = anatomy_of(scan.grey, 3, 0);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  const CoarseBody b = coarse_body(anatomy);
  if (b.places.empty()) throw std::runtime_error("the scan holds no body");
  const VoxelFeatures features(b);
  const auto probabilities = class_probabilities(features, forest);
  if (!probabilities) throw std::runtime_error(probabilities.error().message());
  LabellingScore out;
  out.pieces = body_pieces(b, *probabilities);
  const LimbSegments segments = limb_segments(b, *probabilities, out.pieces, forest);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  out.processor_seconds = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;

  const auto truth = truth_of(b, scan.parts);
  std::vector<int> exact_limb, found_limb, exact_class, found_class;
  std::vector<double> piece_voxels(out.pieces.list.size(), 0);
  out.piece_right.assign(out.pieces.list.size(), 0);
  for (std::size_t n = 0; n < truth.size(); ++n) {
    const int exact = voxel_class(truth[n]);
    exact_limb.push_back(limb_of(truth[n])), found_limb.push_back(limb_of(segments.part[n]));
    exact_class.push_back(exact);
    found_class.push_back(out.pieces.piece[n] < 0 ? -1 : segments.voxel_class[n]);
    if (exact < 0) continue;
    ++out.voxels;
    const std::uint8_t* const shares = probabilities->of(n);
    out.right += std::max_element(shares, shares + voxel_class_count) - shares == exact;
    calibrate(*probabilities, n, static_cast<int>(region_of(static_cast<std::size_t>(exact))), out);
    out.right_piece += found_class.back() == exact;
    if (out.pieces.piece[n] < 0) continue;
    const auto p = static_cast<std::size_t>(out.pieces.piece[n]);
    ++piece_voxels[p];
    const BodyPiece& piece = out.pieces.list[p];
    const bool region_right = region_of(static_cast<std::size_t>(exact)) == piece.region;
    out.piece_right[p] += region_right && (piece.side < 0 || limb_of(truth[n]) % 2 == piece.side);
  }
  for (double* share : {&out.right, &out.right_region, &out.right_piece}) *share /= std::max(1.0, out.voxels);
  for (std::size_t p = 0; p < piece_voxels.size(); ++p) out.piece_right[p] /= std::max(1.0, piece_voxels[p]);
  out.limb_dice = dice_of<6>(found_limb, exact_limb);
  out.class_dice = dice_of<voxel_class_count>(found_class, exact_class);
  const auto joints = true_joints(b, truth);
  for (const ProposedJoint& joint : segments.joints)
    if (const auto it = joints.find(joint.name); it != joints.end())
      out.joints.push_back({joint.name, joint.point - it->second, joint.deviation});
  return out;
}

LabelledScan mirrored(LabelledScan scan) {
  for (Grid* grid : {&scan.grey.grid, &scan.parts.grid}) grid->axes.row(0) *= -1, grid->origin[0] *= -1;
  std::array<std::uint8_t, parts.size()> swapped{};
  for (std::size_t n = 0; n < parts.size(); ++n) {
    std::string name(parts[n].name);
    if (name.ends_with("_left"))
      name.replace(name.size() - 4, 4, "right");
    else if (name.ends_with("_right"))
      name.replace(name.size() - 5, 5, "left");
    swapped[n] = static_cast<std::uint8_t>(part_label(name));
  }
  for (std::uint8_t& part : scan.parts.voxels) part = swapped[part];
  return scan;
}

LabelledScan without_limb(LabelledScan scan, BodyRegion limb, int side) {
  for (std::size_t o = 0; o < scan.parts.voxels.size(); ++o) {
    std::uint8_t& part = scan.parts.voxels[o];
    if (limb_of(part) != (limb == BodyRegion::arm ? 2 : 4) + side) continue;
    part = 0, scan.grey.voxels[o] = -1000;
  }
  return scan;
}

}  // namespace borelli::suite
