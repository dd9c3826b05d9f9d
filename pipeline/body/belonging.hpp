// Whether labels, landmarks and findings are those of the scan: files of two bodies, or of one that was
// moved, give a table all the same, and nothing in it looks wrong.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "inertia/table.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

/// What of a label map lies in the air around the body, and what of the body has no label. Lungs and gut are
/// of the body (body_mask.hpp); so is a voxel at the skin that holds a fifth of tissue.
struct LabelsInAir {
  std::array<double, 256> share{};           ///< of each label's voxels, 0 to 1
  double all = 0;                            ///< of all labelled voxels
  double bare = 0;                           ///< what of the body in view has no label, of the body
  std::vector<std::size_t> doubtful, wrong;  ///< labels over doubtful_in_air, over wrong_in_air
};

/// Of sound maps (25 drawn bodies at 2 to 8 mm by their own labels and by ours, the ICRP male by ours and by
/// its organs, three real scans) the worst part has .001 in air. Of one body's map that was moved by 3 mm
/// sideways the worst part, a hand, has .12 and the whole .02; by 30 mm .9 and .2.
inline constexpr double doubtful_in_air = 0.02, wrong_in_air = 0.1;

/// A label's name, or its number in words where it has none.
std::string name_of_label(const LabelMap& labels, std::size_t label);

/// Both lie on one grid; CT numbers or densities (of MR, as read_mr estimates them).
LabelsInAir labels_in_air(const GreyVolume& volume, const LabelMap& labels, int threads = 0);

/// A sentence for labels over the limit; empty where there is none.
std::string in_words(const LabelsInAir& air, const LabelMap& labels);

/// Of somebody else's classes, on any grid: where bone or lung is among them, whether they lie where the scan
/// shows their tissues (class_fit.hpp); else what lies in air, of those that are flesh.
std::string doubt_of_classes(const GreyVolume& volume, const ClassLabels& classes, int threads = 0);

/// Findings and label map of one segmentation agree in each part's volume. Error: in most they do not.
/// Otherwise the parts that differ (labels mended by hand), in a sentence; empty where none does.
Result<std::string> compare_volumes(const std::array<PartFinding, parts.size()>& findings,
                                    const LabelMap& labels);

/// Thighs and upper arms that are named left lie to the patient's left of those named right (a body may cross
/// what hangs on them). A sentence where they do not: the names are exchanged, or the header is mirrored or
/// turned by half a turn; empty where they do.
std::string compare_sides(const LabelMap& labels);

/// A part's gravity centre lies within its length from its joint. (Of the drawn bodies and the ICRP male .26
/// to .91 of it away; where landmarks and table are of two of them, .8 to 4.9.) Error: of more than a third
/// of those that can be checked it does not. Otherwise those of which it does not, in a sentence.
Result<std::string> compare_centres(const InertiaTable& table, const Landmarks& landmarks);

/// A joint centre lies where its two parts meet. Error: most of those that can be checked lie elsewhere.
/// Otherwise those that do, in a sentence.
Result<std::string> compare_joints(const Landmarks& landmarks, const LabelMap& labels);

}  // namespace borelli
