// Makes the face unrecognisable in everything shown of a body. As in Quickshear (Schimke & Hale (2011),
// HealthSec), a plane cuts off the front of the head, so that the surface in front of it cannot be
// reconstructed.
//
// The plane is parallel to the face (a line through the foremost points from forehead to chin) and 0.22 of
// the head's depth behind it, about 42 mm in an adult. Eyes, nose, mouth and chin lie in front of it. The
// trunk's axes tell which way the head faces. If the cranium is clearly longer than wide, its long axis
// refines this within 45 degrees. Unchanged: ears, the outline of the jaw, the back of the head, the inside
// of the head and everything below the head's part.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "pipeline/export/mesh.hpp"
#include "pipeline/export/thumbnail.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct FaceCut {
  std::uint8_t head = 0;         ///< label of the head
  Eigen::Vector3d point, front;  ///< the plane, mm, LPS; `front` is its unit normal, out of the face
  Eigen::Matrix3d axes;          ///< columns: left, back, up of the head; orthonormal
  Eigen::Vector3d low, high;     ///< the head's box along these axes, mm

  /// Whether a place is removed if the head, or no part, is there.
  bool takes(const Eigen::Vector3d& place) const;
};

/// The plane that removes the face; empty if the label map has no voxel of a part named head.
std::optional<FaceCut> face_cut(const LabelMap& labels, const Landmarks& landmarks);

/// Removes the face from a scan's copy: from the head's label, and from the grey values there and around.
void deface(Thumbnail& copy, const FaceCut& cut);

/// Warning if defacing was requested and no head was found.
inline constexpr std::string_view no_face_found =
    "--deface found no head, so no face was removed; the report shows grey values only inside the labelled "
    "parts; check it before you share it";

/// Without a head: keeps grey values only where labels are.
void keep_labelled(Thumbnail& copy);

/// Makes the head's surface again, without the face. Errors: as part_meshes.
Result<void> deface(std::vector<Mesh>& meshes, const LabelMap& labels, const FaceCut& cut,
                    const MeshOptions& options);

}  // namespace borelli
