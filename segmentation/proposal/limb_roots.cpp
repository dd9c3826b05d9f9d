#include "segmentation/proposal/limb_roots.hpp"

#include <algorithm>
#include <cmath>

namespace borelli {
namespace {

using Eigen::Vector3d;

// from a left limb's root in bone to the head's centre, mm: medians over the roots behind root_deviation
const Vector3d to_humeral_head(21, -18, -9), to_femoral_head(3, -8, -10);
// Places nearer than near_by are equally likely: a root may be 50 mm off, so edges distinguish a head from
// other round bones better. mm
constexpr double near_by = 60, width = 20, farthest = 120;

double likelihood_of(const std::optional<Vector3d>& joint, const Vector3d& point) {
  if (!joint) return 1;
  const double off = (point - *joint).norm();
  return off > farthest ? 0 : std::exp(-0.5 * std::pow(std::max(0.0, off - near_by) / width, 2));
}

}  // namespace

LimbRoots::LimbRoots(const Anatomy& a, BodyRegion limb) {
  if (!a.proposal) return;
  for (const int side : {left_side, right_side}) {
    const BodyPiece* piece = a.proposal->piece(limb, side);
    // the border of a limb that the scan cuts just beyond the joint is unreliable
    constexpr double least_chain = 200;  // mm: half a femur
    if (!piece || !piece->root || !piece->root_in_bone || piece->bone_chain < least_chain) continue;
    Vector3d offset = limb == BodyRegion::arm ? to_humeral_head : to_femoral_head;
    offset[0] *= side_sign(side);
    joint[static_cast<std::size_t>(side)] = *piece->root + offset;
    confidence[static_cast<std::size_t>(side)] = piece->confidence;
  }
}

bool LimbRoots::sure(int side) const {
  constexpr double least = 0.65;
  const auto n = static_cast<std::size_t>(side);
  return joint[n] && confidence[n] >= least;
}

double LimbRoots::likelihood(const Vector3d& left, const Vector3d& right) const {
  return likelihood_of(joint[0], left) * likelihood_of(joint[1], right);
}

}  // namespace borelli
