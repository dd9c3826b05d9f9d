// What a magnetic resonance image shows of a body: where it is, its tissues by their brightness, and what
// they weigh.
//
// MR has no scale such as CT numbers, and cortical bone and air are both dark in it. So the tissues are three
// classes (dark, lean, fat) of this scan's own brightness, after correction of its bias field: k-means, the
// dark class at no signal, and fat taken as the brightest, as in T1-weighted scans and T2-weighted ones by
// fast spin echo without suppression of fat. Dark places within the body that are more than 20 mm thick are
// gas or lung, thinner ones cortical bone, tendon and ligament.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "error/error.hpp"
#include "segmentation/class_map.hpp"
#include "segmentation/volume.hpp"

namespace borelli {

enum class MrTissue : std::uint8_t { outside, dark, lean, fat, gas };
inline constexpr std::array<std::string_view, 5> mr_tissue_names{"outside", "dark tissue", "lean tissue",
                                                                 "fat", "gas or lung"};
/// kg/m^3: adipose tissue and muscle of ICRU Report 44; dark tissue half way between tendon (1100) and
/// cortical bone (1920); lung as in ICRP Publication 110 (382). What is dark is the weakest of these, see the
/// warnings.
inline constexpr std::array<int, 5> mr_tissue_density{0, 1500, 1050, 950, 382};

/// What the densities that a reading gives may be off by, kg/m^3: (density, its standard deviation). Dark
/// tissue is anything from tendon to cortical bone (as if evenly spread between); muscle and adipose tissue
/// by the spread of their published densities (ICRU Report 44, ICRP Publication 110); lung from expiration to
/// inspiration; bones as their mineral varies.
inline constexpr std::array<std::pair<int, int>, 6> mr_density_deviations{
    {{1500, 237}, {1050, 15}, {950, 20}, {382, 110}, {1920, 80}, {1180, 60}}};

struct MrReading {
  GreyVolume density;  ///< of the scan's grid, kg/m^3; 0 outside the body
  LabelMap tissues;    ///< of the scan's grid; label 17 on, so that none is taken for a part
  std::array<double, 5>
      brightness{};  ///< middling value of each class in the corrected image, in the scan's own values
  std::array<double, 5> litres{};
  std::vector<std::string> warnings;  ///< what this reading rests on, in plain words
};

/// The body alone, of one density, for finding parts by classes or landmarks: no bone is to be read off an
/// MR.
GreyVolume flat_body(const MrReading& reading);

/// Reads an MR volume. `classes`, where given (on any grid), tell body and bone: bone then weighs as cortical
/// (1920) where it is dark and as spongiosa with its marrow (1180) where it is not. Errors: a volume that is
/// no MR signal, one without a body.
Result<MrReading> read_mr(const GreyVolume& volume, const ClassMap* classes = nullptr, int threads = 0);

}  // namespace borelli
