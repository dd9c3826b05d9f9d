// Checks whether labels, landmarks and findings belong to the scan. Files of two bodies, or of a body that
// was moved, also give a table, and nothing in that table looks wrong.
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

/// How much of a label map lies in the air around the body, and how much of the body has no label. Lungs and
/// gut belong to the body (body_mask.hpp), and so does a voxel at the skin that is one fifth tissue.
struct LabelsInAir {
  std::array<double, 256> share{};           ///< share of each label's voxels in air, 0 to 1
  double all = 0;                            ///< share of all labelled voxels in air, 0 to 1
  double bare = 0;                           ///< share of the body in view that has no label, 0 to 1
  std::vector<std::size_t> doubtful, wrong;  ///< labels above doubtful_in_air and wrong_in_air
};

/// Limits on the share in air. The worst part of a sound map has 0.001 in air (25 drawn bodies at 2 to 8 mm,
/// the ICRP male, three real scans). In a map shifted sideways by 3 mm the worst part, a hand, has 0.12 and
/// the whole map 0.02; shifted by 30 mm, 0.9 and 0.2.
inline constexpr double doubtful_in_air = 0.02, wrong_in_air = 0.1;

/// A label's name; if it has none, its number in words.
std::string name_of_label(const LabelMap& labels, std::size_t label);

/// `volume` and `labels` lie on one grid. `volume` holds CT numbers or densities (MR: as read_mr estimates
/// them).
LabelsInAir labels_in_air(const GreyVolume& volume, const LabelMap& labels, int threads = 0);

/// A sentence on the labels above the limit; "" if there are none.
std::string in_words(const LabelsInAir& air, const LabelMap& labels);

/// Judges another program's classes, on any grid. If bone or lung is among them, checks whether they lie
/// where the scan shows those tissues (class_fit.hpp); otherwise checks how much of the flesh lies in air.
/// Answers a sentence, or "".
std::string doubt_of_classes(const GreyVolume& volume, const ClassLabels& classes, int threads = 0);

/// Compares each part's volume in the findings with the label map of the same segmentation. Error: most parts
/// differ. Otherwise a sentence that names the parts that differ (labels edited by hand), or "".
Result<std::string> compare_volumes(const std::array<PartFinding, parts.size()>& findings,
                                    const LabelMap& labels);

/// Checks that thighs and upper arms named left lie to the patient's left of those named right; other parts
/// may cross the midline. If they do not, answers a sentence: the names are exchanged, or the header is
/// mirrored or turned by 180 degrees. Otherwise "".
std::string compare_sides(const LabelMap& labels);

/// Checks that each part's gravity centre lies within the part's length from its joint. (Drawn bodies and the
/// ICRP male: 0.26 to 0.91 lengths; landmarks and table of two different bodies: 0.8 to 4.9.) Error: more
/// than a third of the checked parts fail. Otherwise a sentence that names those that fail, or "".
Result<std::string> compare_centres(const InertiaTable& table, const Landmarks& landmarks);

/// Checks that each joint centre lies where its two parts meet. Error: most of the checked joints lie
/// elsewhere. Otherwise a sentence that names those that do, or "".
Result<std::string> compare_joints(const Landmarks& landmarks, const LabelMap& labels);

}  // namespace borelli
