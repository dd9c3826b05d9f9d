// From a scan with labels and landmarks to the inertia table: density, skin, moments, frames.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "inertia/density.hpp"
#include "inertia/moments.hpp"
#include "inertia/table.hpp"
#include "pipeline/body/belonging.hpp"
#include "segmentation/labelling/mr_tissues.hpp"
#include "segmentation/labelling/segment.hpp"
#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

struct MeasureOptions {
  std::string density_curve;  ///< of CT numbers; empty: the default. Densities need none, and refuse one
  /// What a voxel stands for: an average (the skin is then grown) or a point. Absent: decided by the skin's
  /// mixed voxels.
  std::optional<Sampling> sampling;
  double blur_reach = 2;            ///< mm, of grow_skin
  std::string cuts = "deleva1996";  ///< convention by which the labels were cut
  std::string frames = "joints";    ///< of the segments: "joints" or "isb"
  std::string sex;                  ///< "male", "female", or empty
  double stature_m = 0;             ///< 0: not known
  std::string pose;                 ///< "supine", "standing" ..., or empty
  SegmentChoice segments;           ///< rows of the table; empty: one for each label
  /// Uncertainty of each density read off an MR (mr_tissues.hpp); empty: densities are exact.
  std::vector<MrDensity> how_sure;
  double noise_to_contrast = 0;  ///< of that MR: noise over the contrast between fat and lean tissue
  bool deviations = true;        ///< give every entry its standard deviation
  int threads = 0;               ///< 0: as many as the machine has
};

/// Values that MeasureOptions::cuts may have: our conventions, and published ways of cutting.
inline const std::vector<std::string> cut_names{"deleva1996", "dempster",   "bone", "joint",
                                                "zatsiorsky", "mcconville", "other"};

/// How much of a part the scan holds, with the reason if it is cut, and how its bounds were found.
struct PartState {
  Completeness completeness = Completeness::whole;
  /// "reaches the scan's edge", "holds hand too: no wrist was found", "omphalion placed by proportion" ...
  std::string why;
  std::string
      doubt;  ///< what else a reader of its row must know; of an absent part too, which is judged anew
};
/// By the part's name.
using PartCompleteness = std::map<std::string, PartState, std::less<>>;

/// Completeness of the parts as our segmentation found them, with its notes.
PartCompleteness completeness_of(const std::array<PartFinding, parts.size()>& findings);

/// Adds a doubt to parts whose labels lie in air (belonging.hpp). A part with much of it in air becomes cut.
void doubt_what_is_air(const LabelsInAir& air, const LabelMap& labels, PartCompleteness& completeness);

/// Warning if --frames isb was given and no segment has the landmarks of an ISB frame.
inline constexpr std::string_view no_isb_frames =
    "no segment has the landmarks of an ISB frame, so all frames follow the joint centres";

/// One row for each name of the label map except "outside" (absent if it has no voxel), or for each segment
/// asked for (segment_rows.hpp), and one row for the whole body. The two grids must agree to a hundredth of a
/// voxel; the volume's is used. `completeness` describes parts by name, and its words begin the notes of
/// their rows; cut_labels (segmentation/labelling/edge_contact.hpp) judges the other parts. Rows note the
/// landmarks that an ISB frame lacks; if no ISB frame can be built, the table's source says "joints". The
/// table warns if mass or density of the whole body is impossible for a person. Errors: a volume that holds
/// neither CT numbers nor densities, another grid, an unknown curve or sex, no labelled voxel.
Result<InertiaTable> measure(const GreyVolume& volume, LabelMap labels, const Landmarks& landmarks,
                             const MeasureOptions& options = {}, const PartCompleteness& completeness = {});

}  // namespace borelli
