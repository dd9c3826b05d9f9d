// A class map at work: bones and flesh told by somebody else's classes, what they leave open by our own
// layers.
//
// A class of one part is that part's, whole. A class of several is divided among these: by whose flesh a
// place is and by the convention's planes; where those say a part that the class does not belong to, the
// nearest of its own in the body's tree has the place. What has no class goes as it would without the map,
// its flesh to the nearest of the bones that the map tells.
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
  /// `map` must outlive this; its labels are brought onto both grids.
  ClassParts(const ClassLabels& map, const Grid& scan, const Grid& work, int threads);

  /// Body and bone after the classes: a class is body, unless it is outside; what is dense in a class of
  /// flesh is no bone (contrast, metal), what is dark in one of bone is (marrow).
  void mend(Anatomy& anatomy, int threads) const;

  /// Part labels of bones and of whole classes on the work grid, given those that were found without classes.
  Volume<std::uint8_t> seeds(const Anatomy& anatomy, const Volume<std::uint8_t>& found,
                             const PartPlanes& planes, const Landmarks& landmarks) const;

  /// Joint centres by the labelled bones: hips and shoulders as spheres through the head where it faces its
  /// socket, the others where two bones meet. A joint found in the scan itself stays where the bones bear it
  /// out. `scan` is what heads are measured in.
  void find_joints(const Anatomy& anatomy, const Volume<std::uint8_t>& seeds, Landmarks& landmarks,
                   std::vector<std::string>& warnings) const;

  enum class Place { open, body, outside };
  /// What the classes say of a voxel of the scan: nothing, that it is body, that it is none.
  Place place(std::size_t offset) const;
  /// The part of a voxel of the scan whose class is body. `owner` is whose flesh the place is, 0 where
  /// unknown.
  int part(std::size_t offset, int owner, const Eigen::Vector3d& point, const PartPlanes& planes) const;

  /// Whether a class lies at a place of the work grid.
  bool at_work(std::size_t offset) const { return work_.voxels[offset] != 0; }

  /// Where left and right of the classes lie the wrong way round, a sentence that says so.
  std::vector<std::string> warnings() const;

 private:
  const ClassRule* rule(const LabelMap& labels, std::size_t offset) const;

  const ClassLabels& map_;
  LabelMap resampled_;    // on the scan's grid, where the map is on another
  const LabelMap& scan_;  // classes on the scan's grid
  LabelMap work_;         // classes on the work grid
};

/// The part of `set` that is nearest to `part` in the body's tree; of two as near, that of the side on which
/// `side` is positive (left) or negative. `set` must not be empty.
int nearest_part(PartSet set, int part, double side);

}  // namespace borelli
