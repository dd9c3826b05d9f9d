// From CT numbers to mass density: published curves by name.
//
// No curve fits every scanner: at the CT numbers of soft tissue the published ones differ by 2 to 4 %, at
// those of dense bone by 15 %. Two checks:
//   the ICRP 110 male (72.991 kg by its organs), with CT numbers 1000 (density - 1) for soft tissue. Error of
//     its mass: schneider2000 +0.54 %, schneider1996 +0.40 %, mcsquare +1.51 %, geant4 -0.87 %,
//     oncentra -0.20 %;
//   tissues of ICRU Report 44 whose CT numbers at 120 kV follow from their composition (Schneider et al 2000,
//     equation 8): the largest error among fat, muscle, skin, brain, blood, gut and cortical bone is 0.8 %
//     for schneider2000, 5 % for schneider1996, 6 % for mcsquare, 14 % for geant4 and 2 % for oncentra.
// So schneider2000 is the default: it alone is accurate in each tissue. A mass that is right in total but
// wrong in bone would be distributed wrongly. Its weakness is 100 HU, where it falls by 4 %; for scans with
// contrast agent in the vessels consider another curve.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "inertia/moments.hpp"

namespace borelli {

struct DensityCurve {
  std::string name;
  std::string source;                  ///< the publication
  std::vector<Eigen::Vector2d> knots;  ///< (HU, kg/m^3), HU ascending

  /// kg/m^3; linear between knots, constant outside them.
  double at(double hu) const;
};

inline constexpr std::string_view default_density_curve = "schneider2000";

/// All curves, from inertia/data/hu_density.csv, in its order.
const std::vector<DensityCurve>& density_curves();

/// A curve by name. Error: no such curve; the error lists the existing ones.
Result<DensityCurve> density_curve(std::string_view name);

/// Density of CT numbers below -1000.
enum class BelowAir {
  hold,  ///< that of air
  /// Negative: continues the curve straight from air (with its slope from -1000 to -900 HU). So the noise of
  /// voxels in air averages out; `hold` would count only its upper half (with 30 HU of noise, 1.2 % of their
  /// volume as body). For the voxels that grow_skin adds. Padding (below -1500) has density 0.
  straight,
};

/// Density of every grey value, kg/m^3. CT numbers: by the curve. Densities: the value itself (at least 0),
/// without a curve. Error: labels and MR signals, which do not determine density.
Result<GreyWeights> density_weights(Quantity quantity, const DensityCurve& curve,
                                    BelowAir below = BelowAir::hold);

}  // namespace borelli
