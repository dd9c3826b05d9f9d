// Uses another program's class map for bones and flesh. Voxels without a class fall back to our own layers.
//
// A class of one part goes to that part as a whole. A class of several parts is divided among them by flesh
// owner and by the convention's planes. If these give a part outside the class, the voxel goes to the class's
// nearest part in the body's tree. Voxels without a class are labelled as without a map, except that flesh
// follows the nearest bone that the map labels.
#pragma once

#include <string>
#include <vector>

#include "segmentation/body/anatomy.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/part_planes.hpp"

namespace borelli {

class ClassParts {
 public:
  /// `map` must outlive this; its labels are resampled onto both grids.
  ClassParts(const ClassLabels& map, const Grid& scan, const Grid& work, int threads);

  /// Corrects the body and bone masks by the classes. A class belongs to the body unless it is `outside`.
  /// Dense voxels in a flesh class are not bone (contrast agent, metal); dark voxels in a bone class are
  /// (marrow).
  void mend(Anatomy& anatomy, int threads) const;

  /// Part labels on the work grid of bones and of classes with one part. `found`: bone labels found without
  /// classes.
  Volume<std::uint8_t> seeds(const Anatomy& anatomy, const Volume<std::uint8_t>& found,
                             const PartPlanes& planes, const Landmarks& landmarks) const;

  /// Joint centres from the labelled bones. Hips and shoulders: a sphere through the part of the head that
  /// faces its socket, measured in the scan. Other joints: where two bones meet. A joint found in the scan
  /// itself is kept if the labelled bones confirm it.
  void find_joints(const Anatomy& anatomy, const Volume<std::uint8_t>& seeds, Landmarks& landmarks,
                   std::vector<std::string>& warnings) const;

  enum class Place { open, body, outside };
  /// What the classes say of a voxel of the scan: nothing (open), body, or outside.
  Place place(std::size_t offset) const;
  /// The part of a voxel of the scan whose class is body. `owner`: the part whose flesh it is, 0 if unknown.
  /// `point`: its centre, LPS, mm.
  int part(std::size_t offset, int owner, const Eigen::Vector3d& point, const PartPlanes& planes) const;

  /// Whether a voxel of the work grid has a class.
  bool at_work(std::size_t offset) const { return work_.voxels[offset] != 0; }

  /// A warning if the classes' left and right are swapped; else empty.
  std::vector<std::string> warnings() const;

 private:
  const ClassRule* rule(const LabelMap& labels, std::size_t offset) const;

  const ClassLabels& map_;
  LabelMap resampled_;    // on the scan's grid, where the map is on another
  const LabelMap& scan_;  // classes on the scan's grid
  LabelMap work_;         // classes on the work grid
};

/// The part of `set` nearest to `part` in the body's tree. A tie goes to the left side if `side` is positive,
/// else to the right. `set` must not be empty.
int nearest_part(PartSet set, int part, double side);

}  // namespace borelli
