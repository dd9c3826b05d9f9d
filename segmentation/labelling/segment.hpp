// From a scan to labelled parts: the whole of segmentation in one call.
//
// The scan is looked at on an isotropic grid along the patient's axes (work_grid): body (body_mask), bones
// (tissues), hips, shoulders and spine (trunk), the ways along the limbs' bones (limbs), landmarks
// (joint_centres, trunk_landmarks, column_levels), then three layers: bones by part (bones), flesh by bone
// (soft_tissue), and the convention's planes (cuts, part_planes), which are applied to the scan's own voxels.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/labelling/segments.hpp"
#include "segmentation/vocabulary/absent_parts.hpp"
#include "segmentation/vocabulary/convention.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"
#include "segmentation/volume/warning.hpp"

namespace borelli {

class Forest;

enum class Coverage {
  absent,  ///< not in the scan
  cut,     ///< in the scan, but not as a part of its own: the scan's edge cuts it, or no plane parts it from
           ///< its neighbour in the limb (then the one nearer the trunk holds both), or it is a stump; the
           ///< note says which
  whole
};
std::string_view name_of(Coverage coverage);

/// A note of a stump begins so: the part ends where one that hangs on it is told to be absent.
inline constexpr std::string_view stump_note = "stump: ";

struct PartFinding {
  Coverage coverage = Coverage::absent;
  double volume = 0;  ///< of its labelled voxels, mm^3
  /// 0 to 1: falls with the deviation of the landmarks that bound the part (1 at none, 0.37 at 30 mm).
  double confidence = 0;
  /// In plain words, empty where nothing is to be said; of a cut part first why it is cut.
  std::string note;
};

struct Segmentation {
  LabelMap labels;      ///< on the scan's own grid, labels as in parts.hpp: all parts, whatever is asked for
  SegmentChoice asked;  ///< what of it is asked for; empty: all
  Landmarks landmarks;  ///< patient frame, mm
  std::vector<std::string> given;  ///< names of those that were given
  std::array<PartFinding, parts.size()> part{};
  Convention convention = Convention::deleva1996;  ///< by which the parts were cut
  AbsentParts absent{};  ///< told to be absent: they have no label, no landmark and no finding
  std::vector<Warning> warnings{};
};

/// Steps of the work grid that parts are found on, mm: on coarser grids the ankles of slight bodies are lost.
inline constexpr double finest_step = 1, coarsest_step = 6;

struct SegmentOptions {
  double step = 3;    ///< of the work grid, mm, from finest_step to coarsest_step
  int threads = 0;    ///< 0: as many as the machine has
  Landmarks given{};  ///< placed by hand: these take the place of those found
  /// Somebody else's classes, which then tell bones and flesh (class_parts.hpp); outlives the call.
  const ClassLabels* classes = nullptr;
  Convention convention = Convention::deleva1996;  ///< by which the parts are cut
  AbsentParts absent{};                            ///< what the body lacks: nothing is looked for there
  const Forest* forest =
      nullptr;  ///< asked what each place is; null: the program's own. It outlives the call.
  /// Called with the share done (0 to 1) and what is done next.
  std::function<void(double, std::string_view)> progress{};
};

/// Parts of a CT or density volume. Parts that the scan does not hold are absent, never invented; so are
/// those told to be. Errors: a volume that is neither CT numbers nor densities, an empty one, one without a
/// body in it.
Result<Segmentation> segment(const GreyVolume& volume, const SegmentOptions& options = {});

}  // namespace borelli
