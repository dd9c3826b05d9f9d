// The body, its tissues and their densities from a magnetic resonance (MR) image.
//
// MR has no calibrated scale like CT numbers, and cortical bone and air are both dark. So the tissues are
// three brightness classes (dark, lean, fat), found by k-means after bias field correction. The dark class is
// centred at no signal. Fat is taken as the brightest, as in T1-weighted images and in fast spin echo
// T2-weighted images without fat suppression. Dark regions in the body thicker than 20 mm are gas or lung;
// thinner ones are cortical bone, tendon and ligament. The body's edge is where the brightness falls to half
// of that at the skin.
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
/// kg/m^3: adipose tissue and muscle of ICRU Report 44; lung as in ICRP Publication 110 (382). Dark tissue is
/// half way between tendon (1100) and cortical bone (1920). It is the least certain of these; the warnings
/// say so.
inline constexpr std::array<int, 5> mr_tissue_density{0, 1500, 1050, 950, 382};

/// Uncertainty of such a density.
struct MrDensity {
  int density;    ///< kg/m^3, as it stands in MrReading::density
  double shared;  ///< standard deviation common to all parts of a body, kg/m^3
  double own;     ///< standard deviation independent for each part, kg/m^3
  /// Mean error that noise causes in this class by putting voxels into another class, kg/m^3.
  double noise = 0;
};
/// Sources of the ranges, kg/m^3:
///   fat          adipose tissues of ICRU 44: 930 to 970; marrow with its bone (1180) also counts as fat
///   lean         muscle 1050, brain 1040, blood 1060, liver 1060, skin 1090
///   dark         tendon 1100 to cortical bone 1920, down to air in head and gut. Each litre of cortex has
///                two litres of spongiosa (ICRP 110: about twice the cortex). That counts as fat but weighs
///                230 more
///   gas or lung  260 (ICRU 44, inflated) to 500 (exhaled), or dark tissue taken for gas
///   bone by classes: the spread of ICRP 110's spongiosas (1050 to 1190, marrow cavities 980), and cortex
///                with the soft tissue in its voxels
inline constexpr std::array<MrDensity, 7> mr_density_deviations{{{1500, 140, 200},
                                                                 {1050, 8, 5},
                                                                 {950, 15, 12},
                                                                 {382, 50, 50},
                                                                 {1920, 60, 100},
                                                                 {1180, 40, 60},
                                                                 {1, 0, 0}}};

struct MrReading {
  GreyVolume density;                  ///< on the scan's grid, kg/m^3; 0 outside the body
  LabelMap tissues;                    ///< on the scan's grid; labels from 17 on, distinct from parts
  std::array<double, 5> brightness{};  ///< median of each class after bias correction, in the scan's values
  std::array<double, 5> litres{};
  double noise = 0;                   ///< standard deviation in the scan's own values
  std::vector<MrDensity> how_sure;    ///< one for each density in use
  std::vector<std::string> warnings;  ///< assumptions of this reading, one sentence each
};

/// The body with one uniform density, for finding parts by classes or landmarks: MR shows no bone directly.
GreyVolume uniform_body(const MrReading& reading);

/// Reads an MR volume. `classes`, if given (on any grid), define body and bone: dark bone then counts as
/// cortical (1920), other bone as spongiosa with its marrow (1180). Errors: a volume that is no MR signal,
/// one without a body.
Result<MrReading> read_mr(const GreyVolume& volume, const ClassLabels* classes = nullptr, int threads = 0);

}  // namespace borelli
