#include "segmentation/labelling/scan_check.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

#include "segmentation/vocabulary/absent_parts.hpp"

namespace borelli {
namespace {

using Eigen::Vector3d;

// Share of the voxels on the scan's outer faces that are 0.
double zeros_at_border(const GreyVolume& volume) {
  const auto& size = volume.grid.size;
  std::int64_t zeros = 0, all = 0;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j) {
      const bool whole_row = k == 0 || k == size[2] - 1 || j == 0 || j == size[1] - 1;
      for (std::int64_t i = 0; i < size[0]; i += whole_row ? 1 : std::max<std::int64_t>(size[0] - 1, 1)) {
        zeros += volume.at(i, j, k) == 0;
        ++all;
      }
    }
  return all > 0 ? double(zeros) / double(all) : 0;
}

Result<void> check_values(const GreyVolume& volume) {
  if (volume.quantity != Quantity::hu && volume.quantity != Quantity::density_kgm3)
    return failure("segmentation",
                   volume.quantity == Quantity::labels
                       ? "this volume is a label map, and parts are found in CT numbers or densities; give "
                         "its scan as the volume (run, segment and inertia take this file with --labels)"
                       : "this volume contains magnetic resonance signal, and parts are found in CT numbers "
                         "or densities; give a label map of its parts with --labels, or state what it holds "
                         "(--quantity hu or density_kgm3)");
  if (volume.grid.count() == 0 || volume.voxels.size() != volume.grid.count())
    return failure("segmentation", "the volume contains no voxels");
  if (volume.quantity == Quantity::hu && *std::min_element(volume.voxels.begin(), volume.voxels.end()) >= 0)
    return failure("segmentation",
                   "these CT numbers show neither air nor fat, since none is below 0; subtract 1024 if it "
                   "was added, or state what they are (--quantity density_kgm3)");
  // tissue and air are noisy: few voxels of an outermost slice through a body share one exact value
  constexpr double most_zeros = 0.05;
  if (const double zeros = zeros_at_border(volume); volume.quantity == Quantity::hu && zeros > most_zeros)
    return failure(
        "segmentation",
        fmt::format("{:.2g} % of the scan's outermost voxels are exactly 0 HU: the picture was padded there "
                    "with the value of water, which would be weighed as body; pad it with -1000, or crop it",
                    100 * zeros));
  return {};
}

Result<void> check_extent(const Grid& grid) {
  constexpr double largest_scan = 5000;  // mm: the work grid spans the whole scan
  const Eigen::Array3d extent =
      grid.spacing().array() *
      Eigen::Map<const Eigen::Array<std::int64_t, 3, 1>>(grid.size.data()).cast<double>();
  if (extent.maxCoeff() > largest_scan)
    return failure(
        "segmentation",
        fmt::format(
            "the scan measures {:.3g} x {:.3g} x {:.3g} m, more than any body; check the unit of its voxels",
            extent[0] / 1e3, extent[1] / 1e3, extent[2] / 1e3));
  return {};
}

Result<void> check_places(const Landmarks& given, const Grid& grid) {
  for (const auto& [name, landmark] : given) {
    constexpr double beyond = 100;  // mm: a joint may lie somewhat beyond the scan's end
    const Vector3d index = grid.index(landmark.point);
    Vector3d inside;
    for (int c = 0; c < 3; ++c)
      inside[c] = std::clamp(index[c], 0.0, static_cast<double>(grid.size[static_cast<std::size_t>(c)] - 1));
    if (const double off = (grid.point(inside) - landmark.point).norm(); off > beyond)
      return bad_use("landmarks", fmt::format("{} lies {:.0f} mm outside the scan; check that its "
                                              "coordinates are in mm, and in LPS or RAS as its file says",
                                              name, off));
  }
  return {};
}

}  // namespace

Result<void> check_scan(const GreyVolume& volume, const SegmentOptions& options) {
  if (auto fine = check_values(volume); !fine) return fine;
  if (!(options.step >= finest_step && options.step <= coarsest_step))
    return bad_use("segmentation", fmt::format("the work grid's spacing is {:.6g} mm; choose {:g} to {:g} mm",
                                               options.step, finest_step, coarsest_step));
  if (auto fine = check_extent(volume.grid); !fine) return fine;
  if (auto fine = check_places(options.given, volume.grid); !fine) return fine;
  return check_given(options.absent, options.given);
}

}  // namespace borelli
