// Voxel size from headers that give it in several places: NIfTI in sform, qform and pixdim; NRRD in space
// directions, spacings and thicknesses; MetaImage in ElementSpacing, ElementSize and TransformMatrix.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// The voxel size by one field of a header.
struct SizeField {
  std::string name;      ///< as the format calls it
  Eigen::Vector3d size;  ///< lengths along the three axes; not positive: not given
  /// The field may differ without error, as slice thickness does from slice spacing. It has half a vote.
  bool may_differ = false;
};

/// The size by majority of the fields, axis by axis. Sizes agree within 1 %; of those that agree, the first
/// field's number is returned. A field of 1 x 1 x 1, which is what programs leave where they set nothing,
/// does not vote against another field of three lengths. Adds a warning if fields differ. A single field is
/// returned unchecked. Errors: no majority; an axis whose size no field gives; only fields that may differ
/// contradict one of 1 x 1 x 1.
Result<Eigen::Vector3d> voxel_size(const std::string& path, const std::vector<SizeField>& fields,
                                   std::vector<std::string>& warnings);

/// Scales the columns of `axes` to the lengths in `size`, unless they agree within 0.1 %.
void resize_axes(Eigen::Matrix3d& axes, const Eigen::Vector3d& size);

}  // namespace borelli
