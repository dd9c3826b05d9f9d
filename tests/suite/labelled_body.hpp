// An adult of ICRP Publication 110: the part of each voxel, landmarks, and tissue contacts.
//
// Owners. A bone's owner follows from its organ number and side (x left or right of the pelvis' middle). The organ list
// counts parts of the femoral condyles as tibia; these get the femur's numbers.
// Flesh belongs to the bone with the shortest path through tissue. No path crosses a contact: between arm
// tissue and other tissue below the armpit (where the organ list names arm tissue), and between the legs
// below the crotch.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "segmentation/vocabulary/landmarks.hpp"
#include "segmentation/vocabulary/parts.hpp"
#include "segmentation/volume/volume.hpp"
#include "tests/suite/body_lattice.hpp"

namespace borelli::suite {

struct LabelledBody {
  std::string name;  ///< "am" or "af"
  Grid grid;         ///< axes along the patient's, all steps positive
  // By number of the body's voxels (`extra skin` and outside air are none):
  std::vector<std::uint32_t> voxel;    ///< offset in the grid
  std::vector<std::uint8_t> organ;     ///< 1 to 140
  std::vector<std::uint8_t> owner;     ///< part
  std::vector<std::uint8_t> bone;      ///< 1 of bone with its marrow, and of teeth
  std::vector<std::uint8_t> contact;   ///< contact class of tissue, see `may_touch`
  std::vector<std::uint8_t> off_bone;  ///< path length to the owner's bone, mm, up to 255
  std::vector<std::int16_t> hu, density;
  std::vector<std::uint32_t> number;  ///< by offset: 1 + the voxel's number, 0 outside
  Landmarks landmarks;                ///< from `find_body_landmarks`
  double mass = 0;                    ///< kg
  BodyLattice lattice;

  bool is(std::size_t n, int first, int last) const { return organ[n] >= first && organ[n] <= last; }
  Eigen::Vector3d centre(std::size_t n) const {
    const std::int64_t o = voxel[n], plane = grid.size[0] * grid.size[1];
    return grid.point(o % grid.size[0], o % plane / grid.size[0], o / plane);
  }
};

/// Whether tissues of two contact classes are continuous where they meet.
bool may_touch(std::uint8_t a, std::uint8_t b);

/// Lengths of the shortest paths (mm) through tissue from seeds, by number of voxel; `no_tissue_path` if
/// longer than `longest`. `seed` holds the seeds' labels (0: none); `nearest` receives the label at each
/// path's start.
inline constexpr float no_tissue_path = std::numeric_limits<float>::infinity();
std::vector<float> paths_through(const LabelledBody& body, const std::vector<std::uint8_t>& seed,
                                 float longest, std::vector<std::uint8_t>* nearest = nullptr);

/// The part of each bone voxel by organ number and side, 0 of flesh.
std::vector<std::uint8_t> bone_parts(const LabelledBody& body);

/// From volumes on one grid, whose axes are the patient's: organ ids (0 outside, 141 left out), CT numbers,
/// densities in kg/m^3. All else is derived.
LabelledBody labelled_body(const std::string& name, const Volume<std::int16_t>& organs,
                           const Volume<std::int16_t>& hu, const Volume<std::int16_t>& density);

/// "am" or "af" from shared/volumes, split into slices of at most 3 mm (see finer_slices). Errors: files missing
/// (one sentence), not of one grid.
Result<LabelledBody> read_labelled_body(const std::string& name, const std::string& shared_folder);

}  // namespace borelli::suite
