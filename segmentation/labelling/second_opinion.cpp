#include "segmentation/labelling/second_opinion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "segmentation/joints/limb_lengths.hpp"
#include "segmentation/proposal/limb_roots.hpp"
#include "segmentation/vocabulary/part_words.hpp"
#include "segmentation/volume/nearest_whole.hpp"

namespace borelli {
namespace {

constexpr double least_share = 0.08;   // of a part's own volume
constexpr double least_volume = 60e3;  // mm^3
constexpr double contradicted = 0.3;   // confidence

using Counts = std::array<std::array<double, body_limbs.size()>, parts.size()>;

// volume of each part, mm^3, by the limb that the proposal is sure of
Counts volumes_of(const Proposal& proposal, const LabelMap& labels) {
  Counts out{};
  const Grid& g = proposal.grid;
  const double each = labelling_step * labelling_step * labelling_step;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const std::uint8_t limb = proposal.limb[g.offset(i, j, k)];
        if (!limb) continue;
        const Eigen::Vector3d index = labels.grid.index(g.point(i, j, k));
        const auto x = nearest_whole(index[0]), y = nearest_whole(index[1]), z = nearest_whole(index[2]);
        if (labels.grid.holds(x, y, z)) out[labels.at(x, y, z)][limb] += each;
      }
  return out;
}

// 99 % quantile of the distance between a true and a proposed joint whose coordinates have a standard
// deviation of 1 (chi distribution, 3 degrees of freedom)
constexpr double by_chance = 3.37;

// Raises the deviation of a joint that lies `off` mm from the proposed one, if chance does not explain that.
void doubt_joint(const std::string& name, double off, double deviation, Landmarks& landmarks) {
  if (off <= by_chance * std::hypot(deviation, landmarks.at(name).deviation)) return;
  const auto side = name.rfind('_');
  raise_deviation(name.substr(0, side), name.substr(side), off / 2, landmarks);
}

// index into body_limbs of the limb that the proposal is sure of at a point; 0: none
std::size_t limb_at(const Proposal& proposal, const Eigen::Vector3d& point) {
  const Eigen::Vector3d index = proposal.grid.index(point);
  const auto i = nearest_whole(index[0]), j = nearest_whole(index[1]), k = nearest_whole(index[2]);
  return proposal.grid.holds(i, j, k) ? proposal.limb[proposal.grid.offset(i, j, k)] : 0;
}

}  // namespace

bool heads_agree(const Proposal& proposal, const Trunk& trunk) {
  const auto agrees = [&](const std::optional<FoundSphere>& head, bool gone, BodyRegion region, int side) {
    const std::size_t limb = head && !gone ? limb_at(proposal, head->centre) : 0;
    return limb == 0 || limb == limb_of(region, side);
  };
  for (const int side : {left_side, right_side}) {
    const auto n = static_cast<std::size_t>(side);
    if (!agrees(trunk.hip[n], trunk.no_leg[n], BodyRegion::leg, side) ||
        !agrees(trunk.shoulder[n], trunk.no_arm[n], BodyRegion::arm, side))
      return false;
  }
  return true;
}

void doubt_joints_by_proposal(const Anatomy& a, const AbsentParts& absent, Landmarks& landmarks) {
  std::array<bool, body_limbs.size()> lacks{};
  for (std::size_t part = 1; part < parts.size(); ++part)
    if (absent[part]) lacks[limb_of_part(static_cast<int>(part))] = true;
  // If several pieces were taken for one limb, the proposed joint nearest to the found one counts.
  std::map<std::string, std::pair<double, double>> nearest;  // by name: its distance and its deviation, mm
  for (const ProposedJoint& joint : a.proposal->joints) {
    const auto found = landmarks.find(joint.name);
    if (found == landmarks.end() || joint.deviation <= 0 || lacks[limb_of(joint.region, joint.side)])
      continue;
    const std::pair off((found->second.point - joint.point).norm(), joint.deviation);
    const auto [at, first] = nearest.try_emplace(joint.name, off);
    if (!first) at->second = std::min(at->second, off);
  }
  for (const auto& [name, off] : nearest) doubt_joint(name, off.first, off.second, landmarks);
  // (no shoulders: the root of an arm that lies on the trunk may be misplaced)
  const LimbRoots legs(a, BodyRegion::leg);
  for (const int side : {left_side, right_side})
    if (const auto hip = landmarks.find(std::string("hip") + side_suffix(side));
        hip != landmarks.end() && legs.sure(side))
      doubt_joint(hip->first, (hip->second.point - *legs.joint[static_cast<std::size_t>(side)]).norm(),
                  root_deviation, landmarks);
}

double contradicted_share(const Proposal& proposal, const LabelMap& labels) {
  const Counts volumes = volumes_of(proposal, labels);
  double all = 0, foreign = 0;
  for (std::size_t part = 1; part < parts.size(); ++part)
    for (std::size_t limb = 1; limb < body_limbs.size(); ++limb) {
      all += volumes[part][limb];
      if (limb != limb_of_part(static_cast<int>(part))) foreign += volumes[part][limb];
    }
  return all > 0 ? foreign / all : 0;
}

void doubt_by_proposal(const Proposal& proposal, Segmentation& out) {
  const Counts volumes = volumes_of(proposal, out.labels);
  for (std::size_t part = 1; part < parts.size(); ++part) {
    PartFinding& finding = out.part[part];
    if (finding.coverage == Coverage::absent || finding.volume == 0) continue;
    const std::size_t own = limb_of_part(static_cast<int>(part));
    std::size_t most = 0;
    for (std::size_t limb = 1; limb < body_limbs.size(); ++limb)
      if (limb != own && volumes[part][limb] > volumes[part][most]) most = limb;
    const double foreign = volumes[part][most];
    if (most == 0 || foreign < least_volume || foreign < least_share * finding.volume) continue;
    finding.doubt(contradicted,
                  fmt::format("{:.2g} l of it look like {}", foreign / 1e6, in_words(body_limbs[most])));
  }
  for (std::size_t limb = 1; limb < body_limbs.size(); ++limb) {
    double sure = 0, found = 0;
    for (std::size_t part = 0; part < parts.size(); ++part) {
      sure += volumes[part][limb];
      if (part && limb_of_part(static_cast<int>(part)) == limb) found += volumes[part][limb];
    }
    const double lost = sure - found;
    if (lost < least_volume || lost < least_share * sure) continue;
    out.warnings.push_back(joined_warning(
        WarningKind::part, Severity::doubt, "these limbs are labelled as other parts, completely or partly",
        in_words(body_limbs[limb]), fmt::format("{:.2g} of {:.2g} l", lost / 1e6, sure / 1e6)));
  }
}

}  // namespace borelli
