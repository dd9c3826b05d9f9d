// The border between two touching parts, where the scan itself shows it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "segmentation/volume/volume.hpp"

namespace borelli {

/// CT numbers of a scan along lines, each a mean over some millimetres across the line, so that noise shows
/// no sheets.
class ScanProfile {
 public:
  static constexpr double step = 0.75;  ///< mm, between samples

  explicit ScanProfile(const GreyVolume& scan) : scan_(scan), to_index_(scan.grid.axes.inverse()) {}

  /// Appends the samples from one patient point (mm) towards another, the latter left out.
  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to, std::vector<double>& way) const;

 private:
  const GreyVolume& scan_;  // outlives this
  Eigen::Matrix3d to_index_;
};

/// Where on the way between two lean surfaces, `from` and `to`, through a place of fat (`over`; all patient
/// mm) the scan shows the border, mm from the first: in air left between them, or at the sheet of two skins,
/// denser than the fat on both its sides; of several sheets (muscle may be as thin) the one nearest to where
/// the border is `expected`. Nothing where it shows neither.
std::optional<double> seen_border(const ScanProfile& profile, const Eigen::Vector3d& from,
                                  const Eigen::Vector3d& over, const Eigen::Vector3d& to, double expected);

}  // namespace borelli
