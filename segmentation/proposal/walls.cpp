#include "segmentation/proposal/walls.hpp"

#include <cstddef>

namespace borelli {

std::array<std::uint8_t, body_limbs.size()> kinds_let_in(const Proposal& proposal) {
  std::array<std::uint8_t, body_limbs.size()> out{};
  for (std::size_t limb = 1; limb < out.size(); ++limb) out[limb] = wall_kind(limb);
  const Grid& g = proposal.grid;
  const std::array<std::size_t, 3> strides{1, static_cast<std::size_t>(g.size[0]),
                                           static_cast<std::size_t>(g.size[0] * g.size[1])};
  for (std::size_t o = 0; o < proposal.limb.size(); ++o)
    for (const std::size_t stride : strides) {
      if (o < stride) continue;
      const std::size_t here = proposal.limb[o], there = proposal.limb[o - stride];
      if (here == there || here == 0 || there == 0) continue;
      for (const BodyRegion region : {BodyRegion::arm, BodyRegion::leg}) {
        const std::size_t left = limb_of(region, left_side), right = limb_of(region, right_side);
        if ((here == left && there == right) || (here == right && there == left))
          out[left] = out[right] = static_cast<std::uint8_t>(wall_kind(left) | wall_kind(right));
      }
    }
  return out;
}

void put_walls(Anatomy& a) {
  const auto let_in = kinds_let_in(*a.proposal);
  a.wall = sure_limbs(*a.proposal, a.grid(), a.threads);
  for (std::uint8_t& limb : a.wall) limb = let_in[limb];
}

}  // namespace borelli
