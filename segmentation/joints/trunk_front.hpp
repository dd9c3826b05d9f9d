// The skin before the trunk, where no arm hides it, and the navel in it.
#pragma once

#include <optional>

#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

class TrunkFront {
 public:
  /// Between two levels (mm, patient z). The anatomy and trunk outlive this.
  TrunkFront(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, double low, double high);

  /// Foremost point of the trunk at a level, in the middle or, where an arm lies on it there, the nearest to
  /// it that shows; nothing where none does within a hand's breadth.
  std::optional<Eigen::Vector3d> skin_at(double z) const;
  /// Where the midline skin between two levels lies deepest behind the skin around it; less sure
  /// where an arm lies on some of that.
  std::optional<Landmark> navel(double from, double to) const;

 private:
  std::optional<std::int64_t> front(std::int64_t i, std::int64_t k) const;
  double skin(std::int64_t i, std::int64_t k) const;
  std::optional<double> dent(std::int64_t i, std::int64_t k, int least) const;

  const Anatomy& a_;
  const Trunk& trunk_;
  Mask arm_;                           // flesh that is or may be an arm's, before the middle of the trunk
  std::array<std::int64_t, 3> first_;  // of its voxels, on the work grid
};

}  // namespace borelli
