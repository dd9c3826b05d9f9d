// The voxels' size where a header says it more than once: NIfTI in sform, qform and pixdim; NRRD in space
// directions, spacings and thicknesses; MetaImage in ElementSpacing, ElementSize and TransformMatrix.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// What one field of a header says of the voxels' size.
struct SizeField {
  std::string name;      ///< as the format calls it
  Eigen::Vector3d size;  ///< lengths along the three axes; what is not a positive number says nothing
  /// It may rightly differ, as a slice's thickness does from the distance of slices that overlap: it counts
  /// half.
  bool may_differ = false;
};

/// The size that most of the fields give, axis by axis; the first field's own numbers where it is among them.
/// Sizes agree within a hundredth. Where as many say one thing as another, fields that say 1 x 1 x 1 are left
/// out, since that is what stands where nobody set it and where only directions were written. All that
/// differs is said in `warnings`. A single field's size is taken as it is. Errors: no such majority; an axis
/// of which no field says anything.
Result<Eigen::Vector3d> voxel_size(const std::string& path, const std::vector<SizeField>& fields,
                                   std::vector<std::string>& warnings);

/// Gives the columns of `axes` the lengths of `size` where they have others.
void resize_axes(Eigen::Matrix3d& axes, const Eigen::Vector3d& size);

}  // namespace borelli
