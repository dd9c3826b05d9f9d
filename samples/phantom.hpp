// The sample phantom: an adult standing body made of closed solids of known density. Mass, gravity centre and
// inertia tensor of each of the sixteen segments are known, and joint centres are known exactly.
//
// Segments and their lengths after de Leva (1996) J Biomech 29:1223. Two segments meet in a plane, one of
// segmentation/vocabulary/cuts.hpp at the phantom's own landmarks. So correct landmarks and labels reproduce
// the table's masses. Solids are disjoint or nested; a nested solid replaces its parent's material.
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
  bool child = false;  ///< proportions of a six-year-old instead of an adult's
  /// Seed of random variation of each segment's length and thickness, the bones' thickness and the posture,
  /// left and right independently. The same seed gives the same body.
  std::optional<std::uint64_t> variation;
  std::string metal_hip;  ///< femoral head and neck and acetabulum of metal: "left" or "right"; empty: none
  std::optional<double> stature_m;  ///< sole to vertex; by default the mean of de Leva's sample (child: 1.16)
  std::optional<double> mass_kg;    ///< by default the mean of de Leva's sample, scaled with stature^3
  std::string density_curve{default_density_curve};  ///< sets the tissues' densities
  /// Joint angles in degrees by name (see pose_ranges); those not named keep their default.
  std::map<std::string, double> pose_deg;
};

/// A joint angle of the phantom, degrees.
struct PoseAngle {
  std::string_view joint, motion;  ///< named "knee_left_flexion" and so on: joint, side, motion
  double least, most, standing;
};
/// Every angle of a phantom, on each side. Rotation (inwards, about the limb), then flexion, then abduction
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
  int part = 0;             ///< label as in parts.hpp; 0: not part of the body (the navel's air)
  int parent = -1;          ///< index of the solid that contains this one; -1: none
};

struct Phantom {
  /// Parents before their children. Limbs that touch are solids that overlap; a point in two of them belongs
  /// to the later one.
  std::vector<PhantomSolid> solids;
  Landmarks landmarks;                        ///< exact, patient frame, mm
  std::array<Inertial, parts.size()> exact;   ///< by label, patient axes, m; [0] is empty
  std::array<double, parts.size()> volume{};  ///< by label, m^3
  /// By label: share of a part's volume that another limb or the trunk occupies too. Soft tissue allows a few
  /// hundredths; a pose with more pushes limbs through each other, which is impossible.
  std::array<double, parts.size()> overlap{};
  Inertial whole;
  double girth = 1;  ///< factor on the flesh's thickness that gives the mass
};

/// Builds a body of the given stature and mass. The stature scales everything alike. The mass is then met (to
/// 1e-9) by scaling the cross-sections of the flesh about unchanged bones. Touching limbs share volume that
/// counts once, so the body weighs that much less. Errors: a mass that needs flesh thinner than the bones or
/// thicker than a body's, an angle that is unknown or out of range.
Result<Phantom> build_phantom(const PhantomOptions& options);

/// Index of the innermost solid that holds a point (patient frame, mm), -1 for none.
int solid_at(const Phantom& phantom, const Eigen::Vector3d& point);

}  // namespace borelli
