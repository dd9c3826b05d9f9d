// The sample phantom: an adult standing body made of closed solids of known density, whose mass, gravity
// centre and inertia tensor are known for each of the sixteen segments, and whose joint centres are known
// exactly.
//
// Segments and their lengths after de Leva (1996) J Biomech 29:1223. Two segments meet in a plane, and the
// planes are those of segmentation/vocabulary/cuts.hpp at the phantom's own landmarks: whoever finds the
// landmarks and labels the limbs gets the masses of the table. Solids are disjoint or nested; a nested solid
// takes the place of what its parent holds there.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "inertia/density.hpp"
#include "inertia/inertial.hpp"
#include "samples/elliptic_stack.hpp"
#include "segmentation/vocabulary/cuts.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"

namespace borelli {

enum class Sex { male, female };

struct PhantomOptions {
  Sex sex = Sex::male;
  bool child = false;  ///< proportions of a six-year-old in place of the adult's of either sex
  /// Draws each segment's length and thickness, the bones' and the way the body stands, left and right each
  /// for itself: the same seed gives the same body.
  std::optional<std::uint64_t> variation;
  std::string metal_hip;  ///< head and neck of the femur and its socket of metal: left, right or neither
  std::optional<double> stature_m;  ///< sole to vertex; by default the mean of de Leva's sample (child: 1.16)
  std::optional<double> mass_kg;    ///< by default the mean of de Leva's sample, scaled with stature^3
  std::string density_curve{default_density_curve};  ///< that gives the tissues their densities
  /// Joint angles in degrees by name (see pose_ranges); those not named keep their default.
  std::map<std::string, double> pose_deg;
};

/// A joint angle of the phantom, degrees.
struct PoseAngle {
  std::string_view joint, motion;  ///< named "knee_left_flexion" and so on: joint, side, motion
  double least, most, standing;
};
/// Every angle that a phantom has, on each side. Rotation (inwards, about the limb), flexion, then abduction
/// turn a limb from straight down.
inline constexpr std::array<PoseAngle, 9> pose_angles{{
    {"shoulder", "flexion", -30, 60, 0},
    {"shoulder", "abduction", 0, 165, 12},
    {"shoulder", "rotation", -90, 90, 0},
    {"elbow", "flexion", 0, 130, 0},
    {"wrist", "flexion", -60, 60, 0},
    {"hip", "flexion", -10, 40, 0},
    {"hip", "abduction", -4, 25, 0},
    {"knee", "flexion", 0, 110, 0},
    {"ankle", "dorsiflexion", -15, 5, 0},
}};

struct PhantomTissue {
  std::string_view name;
  int hu;  ///< CT number
};

struct PhantomSolid {
  std::string name;
  EllipticStack shape;
  PhantomTissue tissue;
  double density_kgm3 = 0;  ///< of the density curve at the tissue's CT number
  int part = 0;             ///< label as in parts.hpp; 0: not of the body (the navel's air)
  int parent = -1;          ///< index of the solid in which this one is nested; -1: in none
};

struct Phantom {
  /// Parents before their children. Limbs that touch are solids that overlap: of two that hold a point, the
  /// later has it.
  std::vector<PhantomSolid> solids;
  Landmarks landmarks;                        ///< exact, patient frame, mm
  std::array<Inertial, parts.size()> exact;   ///< by label, patient axes, m; [0] is empty
  std::array<double, parts.size()> volume{};  ///< by label, m^3
  /// By label: the share of a part's place that another limb or the trunk takes up, too. Skin gives way to a
  /// few hundredths; a pose that makes it more pushes limbs through each other, which no body can do.
  std::array<double, parts.size()> overlap{};
  Inertial whole;
  double girth = 1;  ///< the factor on the flesh's thickness that gave the mass
};

/// Builds a body of the given stature and mass. The stature scales everything alike; the mass is then met (to
/// 1e-9 of it) by scaling the cross-sections of the flesh about unchanged bones. Where limbs touch, one takes
/// the other's place, and the body weighs less by what they share. Errors: a mass that needs flesh thinner
/// than the bones or thicker than a body's, an angle that is unknown or out of range.
Result<Phantom> build_phantom(const PhantomOptions& options);

/// Index of the innermost solid that holds a point (patient frame, mm), -1 for none.
int solid_at(const Phantom& phantom, const Eigen::Vector3d& point);

}  // namespace borelli
