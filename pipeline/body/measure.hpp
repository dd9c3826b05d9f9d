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
  /// What the voxels are: averages, whose skin is grown, or points. Nothing: told by the skin's mixed voxels.
  std::optional<Sampling> sampling;
  double blur_reach = 2;            ///< mm, of grow_skin
  std::string cuts = "deleva1996";  ///< convention by which the labels were cut
  std::string frames = "joints";    ///< of the segments: "joints" or "isb"
  std::string sex;                  ///< "male", "female", or empty
  double stature_m = 0;             ///< 0: not known
  std::string pose;                 ///< "supine", "standing" ..., or empty
  SegmentChoice segments;           ///< rows of the table; empty: one for each label
  /// Of densities that were read off an MR (mr_tissues.hpp): how sure each of them is; empty: they are exact.
  std::vector<MrDensity> how_sure;
  double noise_to_contrast = 0;  ///< of that MR: its noise over the contrast of fat to lean tissue
  bool deviations = true;        ///< give every entry its standard deviation
  int threads = 0;               ///< 0: as many as the machine has
};

/// What MeasureOptions::cuts may be: our conventions, and published ways of cutting.
inline const std::vector<std::string> cut_names{"deleva1996", "dempster",   "bone", "joint",
                                                "zatsiorsky", "mcconville", "other"};

/// How much of a part a scan holds; of a cut one, why, and of any how its bounds were found.
struct PartHeld {
  Completeness held = Completeness::whole;
  /// "reaches the scan's edge", "holds hand too: no wrist was found", "omphalion placed by proportion" ...
  std::string why;
  std::string
      doubt;  ///< what else a reader of its row must know; of an absent part too, which is judged anew
};
/// By the part's name.
using PartCompleteness = std::map<std::string, PartHeld, std::less<>>;

/// The same as our segmentation found it, with its notes.
PartCompleteness completeness_of(const std::array<PartFinding, parts.size()>& findings);

/// Parts of a label map whose labels lie in air (belonging.hpp) have a doubt; those with much of it are cut.
void doubt_what_is_air(const LabelsInAir& air, const LabelMap& labels, PartCompleteness& completeness);

/// What is said where --frames isb was asked for and no segment has the landmarks of such a frame.
inline constexpr std::string_view no_isb_frames =
    "no segment has a frame after the ISB, for want of landmarks: frames are by the joints";

/// A row for each name of the label map but "outside" (absent where it has no voxel), or for each segment
/// asked for (segment_rows.hpp), and one for the whole body. The two grids must agree to a hundredth of a
/// voxel; the volume's is used. `completeness` describes parts by name, and begins the notes of their rows;
/// cut_labels (segmentation/labelling/edge_contact.hpp) judges the other parts. Rows note landmarks that an
/// ISB frame lacks; if no ISB frame can be laid, the table's source says "joints". The table's warnings name
/// a whole body whose mass or density no person has. Errors: a volume that holds neither CT numbers nor
/// densities, another grid, an unknown curve or sex, no labelled voxel.
Result<InertiaTable> measure(const GreyVolume& volume, LabelMap labels, const Landmarks& landmarks,
                             const MeasureOptions& options = {}, const PartCompleteness& completeness = {});

}  // namespace borelli
