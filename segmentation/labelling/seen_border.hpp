// Finds the border between two touching parts where the scan shows it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// CT numbers of a scan along lines. Each is a mean over some millimetres across the line, so that noise does
/// not look like skin.
class ScanProfile {
 public:
  static constexpr double step = 0.75;  ///< mm, between samples

  explicit ScanProfile(const GreyVolume& scan) : scan_(scan), to_index_(scan.grid.axes.inverse()) {}

  /// Appends the samples from one point (LPS, mm) towards another, without the end point.
  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to, std::vector<double>& samples) const;

 private:
  const GreyVolume& scan_;  // outlives this
  Eigen::Matrix3d to_index_;
};

/// The visible border on the line between two lean surfaces, `from` and `to`, through a point in fat, `over`
/// (all LPS, mm). Returns its distance from `from`, mm. The border is air between the surfaces, or the sheet
/// of two skins, which is denser than the fat on both sides. Thin muscle can look alike: of several sheets,
/// the one nearest to the `expected` distance (mm) counts. Empty if the scan shows neither.
std::optional<double> seen_border(const ScanProfile& profile, const Eigen::Vector3d& from,
                                  const Eigen::Vector3d& over, const Eigen::Vector3d& to, double expected);

}  // namespace borelli
