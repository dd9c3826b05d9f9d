// What a magnetic resonance image shows of a body: where it is, its tissues by their brightness, and what
// they weigh.
//
// MR has no scale such as CT numbers, and cortical bone and air are both dark in it. So the tissues are three
// classes (dark, lean, fat) of this scan's own brightness, after correction of its bias field: k-means, the
// dark class at no signal, and fat taken as the brightest, as in T1-weighted scans and T2-weighted ones by
// fast spin echo without suppression of fat. Dark places within the body that are more than 20 mm thick are
// gas or lung, thinner ones cortical bone, tendon and ligament. At the skin a body ends where it is half as
// bright as what lies there.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/volume/volume.hpp"

namespace borelli {

enum class MrTissue : std::uint8_t { outside, dark, lean, fat, gas };
inline constexpr std::array<std::string_view, 5> mr_tissue_names{"outside", "dark tissue", "lean tissue",
                                                                 "fat", "gas or lung"};
/// kg/m^3: adipose tissue and muscle of ICRU Report 44; dark tissue half way between tendon (1100) and
/// cortical bone (1920); lung as in ICRP Publication 110 (382). What is dark is the weakest of these, see the
/// warnings.
inline constexpr std::array<int, 5> mr_tissue_density{0, 1500, 1050, 950, 382};

/// How sure such a density is.
struct MrDensity {
  int density;    ///< kg/m^3, as it stands in MrReading::density
  double shared;  ///< standard deviation that all parts of a body have in common, kg/m^3
  double own;     ///< of each part for itself
  /// What noise adds on average to the voxels of this class, by giving some of them to another.
  double noise = 0;
};
/// Fat: adipose tissues of ICRU 44 are 930 to 970, and marrow with its bone (1180) counts as fat. Lean:
/// muscle 1050, brain 1040, blood 1060, liver 1060, skin 1090. Dark: tendon 1100 to cortical bone 1920, whose
/// marrow would weigh two more litres at 230 beyond fat for each litre of it (ICRP 110: spongiosa is some
/// twice cortex), down to air in head and gut. Gas or lung: 260 (ICRU 44, inflated) to 500 breathed out, or
/// what is none. Bone that classes tell: the spread of ICRP 110's spongiosas (1050 to 1190, marrow cavities
/// 980), and cortex with what of soft tissue is in its voxels.
inline constexpr std::array<MrDensity, 7> mr_density_deviations{{{1500, 140, 200},
                                                                 {1050, 8, 5},
                                                                 {950, 15, 12},
                                                                 {382, 50, 50},
                                                                 {1920, 60, 100},
                                                                 {1180, 40, 60},
                                                                 {1, 0, 0}}};

struct MrReading {
  GreyVolume density;  ///< of the scan's grid, kg/m^3; 0 outside the body
  LabelMap tissues;    ///< of the scan's grid; label 17 on, so that none is taken for a part
  std::array<double, 5>
      brightness{};  ///< middling value of each class in the corrected image, in the scan's own values
  std::array<double, 5> litres{};
  double noise = 0;                   ///< standard deviation in the scan's own values
  std::vector<MrDensity> how_sure;    ///< of the densities that there are
  std::vector<std::string> warnings;  ///< what this reading rests on, in plain words
};

/// The body alone, of one density, for finding parts by classes or landmarks: no bone is to be read off an
/// MR.
GreyVolume flat_body(const MrReading& reading);

/// Reads an MR volume. `classes`, where given (on any grid), tell body and bone: bone then weighs as cortical
/// (1920) where it is dark and as spongiosa with its marrow (1180) where it is not. Errors: a volume that is
/// no MR signal, one without a body.
Result<MrReading> read_mr(const GreyVolume& volume, const ClassLabels* classes = nullptr, int threads = 0);

}  // namespace borelli
