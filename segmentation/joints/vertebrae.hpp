// The column's vertebrae: the middle of their bodies, the disc and the spinous process at the neck's foot.
#pragma once

#include <optional>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/joints/trunk.hpp"

namespace borelli {

/// The middle of the column at a level (mm, patient z): half way between the faces of the vertebral bodies
/// just above and below it, front to back (the canal behind them is soft) and side to side. In the `neck`,
/// whose bodies are hardly thicker than its arches, they are told by lying foremost; elsewhere vessels full
/// of contrast medium may lie before them.
Eigen::Vector3d vertebral_body(const Anatomy& anatomy, const Trunk& trunk, double z, bool neck = false);

/// Upper edge of the first rib beside the column, going up from the chest to at most 75 mm (of an adult)
/// above `near`. Nothing where a chest is cut by the scan's top.
std::optional<double> first_rib(const Anatomy& anatomy, const Trunk& trunk, double near);

/// Middle (mm, patient z, between samples) of the disc that is deepest and nearest to where one is expected:
/// about `level`, with a standard deviation of `spread` mm, less than half a vertebra off. Nothing where the
/// scan does not resolve one.
std::optional<double> disc_near(const Anatomy& anatomy, const Trunk& trunk, double level, double spread);

/// Where thick slices leave out a disc that is expected about `level` (mm, patient z): the middle between two
/// slices that is nearest to where the discs of C6/C7 above and T1/T2 below place that of C7/T1, or one of
/// them and `level` together. Nothing where neither is seen.
std::optional<double> disc_between_slices(const Anatomy& anatomy, const Trunk& trunk, double level);

/// The hindmost bone behind the disc between C7 and T1, where the spinous process of C7 ends (those of C6 and
/// T1 end a vertebra's height above and below). `scale`: the body's size, see Trunk.
std::optional<Eigen::Vector3d> spinous_tip(const Anatomy& anatomy, const Eigen::Vector3d& disc, double scale);

}  // namespace borelli
