// The skin of the trunk's front, where no arm hides it, and the navel in it.
#pragma once

#include <optional>
#include <vector>

#include "segmentation/joints/limbs.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

class TrunkFront {
 public:
  /// Prepares the stretch between two levels (mm, patient z). Anatomy and trunk must outlive this object.
  TrunkFront(const Anatomy& anatomy, const Trunk& trunk, const Limbs& limbs, double low, double high);

  /// Foremost point of the trunk in the midline at a level (mm, LPS). If an arm hides it there, takes the
  /// nearest visible place at the sides; empty if none is within 100 mm.
  std::optional<Eigen::Vector3d> skin_at(double z) const;
  /// The dent of the skin near the midline between two levels that is most probably the navel, by its depth and by
  /// its distance from the usual level (mm, patient z; standard deviation `spread`). The other dents' probabilities
  /// raise its deviation, and so does an arm that hides some of its surroundings. Empty if the navel probably
  /// does not show.
  std::optional<Landmark> navel(double from, double to, double usual, double spread) const;

 private:
  struct Dent {
    std::int64_t i, k;  // on the work grid
    double depth;       // mm
  };
  std::vector<Dent> dents(double from, double to) const;
  std::optional<std::int64_t> front(std::int64_t i, std::int64_t k) const;
  double skin(std::int64_t i, std::int64_t k) const;
  std::optional<double> dent(std::int64_t i, std::int64_t k, int least) const;

  const Anatomy& a_;
  const Trunk& trunk_;
  Mask arm_;                           // flesh that is or may be an arm's, in a box around the trunk
  std::array<std::int64_t, 3> first_;  // index of the box's first voxel on the work grid
};

}  // namespace borelli
