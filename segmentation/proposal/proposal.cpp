#include "segmentation/proposal/proposal.hpp"

#include <algorithm>

#include "segmentation/proposal/voxel_features.hpp"
#include "segmentation/volume/nearest_whole.hpp"
#include "threads/slabs.hpp"

namespace borelli {
namespace {

// stores each voxel's limb if the region of its piece is sure
void mark_sure_places(const CoarseBody& body, const BodyPieces& pieces, Proposal& out) {
  out.limb.assign(body.grid().count(), 0);
  for (std::size_t n = 0; n < body.places.size(); ++n) {
    if (pieces.piece[n] < 0) continue;
    const BodyPiece& piece = pieces.list[static_cast<std::size_t>(pieces.piece[n])];
    if (pieces.regions[n][static_cast<std::size_t>(piece.region)] >= sure_region)
      out.limb[body.places[n]] = static_cast<std::uint8_t>(limb_of(piece.region, piece.side));
  }
}

}  // namespace

const BodyPiece* Proposal::piece(BodyRegion region, int side) const {
  const BodyPiece* best = nullptr;
  for (const BodyPiece& each : pieces)
    if (each.region == region && each.side == side && (!best || each.volume > best->volume)) best = &each;
  return best;
}

Proposal proposal_of(const CoarseBody& body, const ClassProbabilities& probabilities, const Forest& forest) {
  BodyPieces pieces = body_pieces(body, probabilities);
  Proposal out;
  out.grid = body.grid();
  mark_sure_places(body, pieces, out);
  LimbSegments segments = limb_segments(body, probabilities, pieces, forest);
  out.joints = std::move(segments.joints);
  out.piece_at.assign(out.grid.count(), -1);
  out.voxel_class.assign(out.grid.count(), 0);
  for (std::size_t n = 0; n < body.places.size(); ++n) {
    out.piece_at[body.places[n]] = pieces.piece[n];
    out.voxel_class[body.places[n]] = segments.voxel_class[n];
  }
  out.pieces = std::move(pieces.list);
  return out;
}

Result<Proposal> propose(const Anatomy& anatomy, const Forest* forest) {
  static const Result<Forest> ready = ready_forest();
  if (!forest && !ready) return tl::unexpected(ready.error());
  if (!forest) forest = &*ready;
  const CoarseBody body = coarse_body(anatomy);
  const auto probabilities = class_probabilities(VoxelFeatures(body), *forest);
  if (!probabilities) return tl::unexpected(probabilities.error());
  return proposal_of(body, *probabilities, *forest);
}

std::size_t Proposal::place_of(const Grid& g, std::int64_t i, std::int64_t j, std::int64_t k) const {
  const double ratio = g.axes(0, 0) / labelling_step;
  const auto at = [&](std::int64_t n, std::size_t c) {
    return std::min(nearest_whole(ratio * static_cast<double>(n)), grid.size[c] - 1);
  };
  return grid.offset(at(i, 0), at(j, 1), at(k, 2));
}

std::vector<std::uint8_t> sure_limbs(const Proposal& proposal, const Grid& g, int threads) {
  std::vector<std::uint8_t> out(g.count(), 0);
  in_slabs(g.size[2], threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i)
          out[g.offset(i, j, k)] = proposal.limb[proposal.place_of(g, i, j, k)];
  });
  return out;
}

}  // namespace borelli
