// A scan and its labels as plain data: the only type that segmentation hands to later stages.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "error/eigen_layout.hpp"

namespace borelli {

/// Where voxels lie: voxel (i, j, k) is centred at origin + axes * (i, j, k), in mm, LPS.
/// The axes need be neither orthogonal nor of equal length (anisotropic, oblique, gantry-tilted grids).
struct Grid {
  std::array<std::int64_t, 3> size{0, 0, 0};           ///< voxels along i (fastest in memory), j, k
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< column c: displacement of one step along c, mm
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< centre of voxel (0, 0, 0), mm

  std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  std::size_t offset(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * size[1] + j) * size[0] + i);
  }
  bool holds(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
  /// Patient point (mm) of a (fractional) index.
  Eigen::Vector3d point(const Eigen::Vector3d& index) const { return origin + axes * index; }
  /// Centre of voxel (i, j, k), mm.
  Eigen::Vector3d point(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return point({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
  }
  /// Fractional index of a patient point (mm).
  Eigen::Vector3d index(const Eigen::Vector3d& point) const { return axes.inverse() * (point - origin); }
  /// Lengths of the three axes, mm.
  Eigen::Vector3d spacing() const { return axes.colwise().norm(); }
  double voxel_volume() const { return std::abs(axes.determinant()); }  ///< mm^3

  bool operator==(const Grid& other) const {
    return size == other.size && axes == other.axes && origin == other.origin;
  }
};

template <class T>
struct Volume {
  Grid grid;
  std::vector<T> voxels;  ///< #grid.count(), i fastest

  T& at(std::int64_t i, std::int64_t j, std::int64_t k) { return voxels[grid.offset(i, j, k)]; }
  const T& at(std::int64_t i, std::int64_t j, std::int64_t k) const { return voxels[grid.offset(i, j, k)]; }
};

/// What the grey values of a volume mean.
enum class Quantity {
  hu,            ///< CT numbers, Hounsfield units
  density_kgm3,  ///< mass density, kg/m^3 (a file in g/cm^3 is scaled to this when it is read)
  labels,        ///< part or organ numbers
  mr             ///< magnetic resonance signal, arbitrary units
};

/// The CT number of voxels that were not measured: outside the scanner's round field of view according to the
/// header, or not a number in the file. All measured voxels are -1024 or more.
inline constexpr std::int16_t padding_hu = -2048;
/// The same for densities; measured voxels are 0 or more.
inline constexpr std::int16_t padding_density = -1;

struct GreyVolume : Volume<std::int16_t> {
  Quantity quantity = Quantity::hu;
};

/// The voxels from `first` to `last` along each axis.
struct IndexBox {
  std::array<std::int64_t, 3> first{}, last{};

  bool holds(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return i >= first[0] && j >= first[1] && k >= first[2] && i <= last[0] && j <= last[1] && k <= last[2];
  }
};

/// A volume of part numbers; label 0 is outside the body.
struct LabelMap : Volume<std::uint8_t> {
  std::vector<std::string> names;         ///< names[label]; names[0] = "outside"
  std::vector<std::string> warnings;      ///< from its reader, one sentence each
  std::optional<IndexBox> labelled = {};  ///< part of `grid` that the file covers; none: all
  std::set<std::uint8_t> beyond = {};     ///< labels of which the file has voxels outside `grid`
};

}  // namespace borelli
