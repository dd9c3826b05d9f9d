// From a scan to labelled parts: the whole segmentation in one call.
//
// The scan is sampled on an isotropic grid along the patient's axes (work_grid). Steps: body (body_mask);
// bones (tissues); hips, shoulders and spine (trunk); the path along each limb's bones (limbs); landmarks
// (joint_centres, trunk_landmarks, column_levels). Three layers follow: bones by part (bones), flesh by bone
// (soft_tissue), and the convention's planes (cuts, part_planes), applied to the scan's own voxels.
#pragma once

#include <algorithm>
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
  cut,     ///< in the scan, but the scan's edge cuts it, no plane separates it from its neighbour in the limb
           ///< (then the one nearer the trunk holds both), or it is a stump; the note says which
  whole
};
std::string_view name_of(Coverage coverage);

/// Prefix of a stump's note: the next part of the limb is given as absent.
inline constexpr std::string_view stump_note = "stump: ";

struct PartFinding {
  Coverage coverage = Coverage::absent;
  double volume = 0;  ///< of its labelled voxels, mm^3
  /// 0 to 1: falls with the deviation of the landmarks that bound the part (1 at 0 mm, 0.37 at 30 mm).
  double confidence = 0;
  /// A sentence, or empty. For a cut part, the first clause says why it is cut.
  std::string note;

  /// Adds a clause to the note, unless the note contains it.
  void say(const std::string& clause) {
    if (note.find(clause) == std::string::npos) note += (note.empty() ? "" : "; ") + clause;
  }
  /// Lowers the confidence to at most `most`, and says why.
  void doubt(double most, const std::string& why) {
    confidence = std::min(confidence, most);
    say(why);
  }
};

struct Segmentation {
  LabelMap labels;                 ///< all parts, on the scan's own grid; labels as in parts.hpp
  SegmentChoice asked;             ///< the requested segments; empty: all
  Landmarks landmarks;             ///< patient frame, mm
  std::vector<std::string> given;  ///< names of landmarks given by the user
  std::array<PartFinding, parts.size()> part{};
  Convention convention = Convention::deleva1996;  ///< that cut the parts
  AbsentParts absent{};                            ///< given as absent: no label, no landmark, no finding
  std::vector<Warning> warnings{};
};

/// Limits of the work grid's step, mm: on coarser grids the ankles of slight bodies are lost.
inline constexpr double finest_step = 1, coarsest_step = 6;

struct SegmentOptions {
  double step = 3;    ///< of the work grid, mm, from finest_step to coarsest_step
  int threads = 0;    ///< 0: as many as the machine has
  Landmarks given{};  ///< placed by hand; they replace those found
  /// Another program's classes, which then define bones and flesh (class_parts.hpp). Must outlive the call.
  const ClassLabels* classes = nullptr;
  Convention convention = Convention::deleva1996;  ///< that cuts the parts
  AbsentParts absent{};                            ///< parts that the body lacks; not searched for
  const Forest* forest = nullptr;  ///< gives the proposal; null: the built-in one. Must outlive the call.
  /// Called with the fraction done (0 to 1) and the name of the next step.
  std::function<void(double, std::string_view)> progress{};
};

/// Segments a CT or density volume. Parts outside the scan, and those given as absent, are absent, never
/// invented. Errors: a volume that holds neither CT numbers nor densities; an empty volume; no body in it;
/// damaged values; impossible options or given landmarks.
Result<Segmentation> segment(const GreyVolume& volume, const SegmentOptions& options = {});

}  // namespace borelli
