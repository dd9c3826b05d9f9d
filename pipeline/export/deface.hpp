// A face made unrecognisable in what is shown of a body: the front of the head is taken away at a plane, as
// Quickshear does it (Schimke & Hale (2011), HealthSec), so that nothing of the surface in front of it is
// left to be drawn again.
//
// The plane lies parallel to the face - a line through the foremost points from forehead to chin - and behind
// it by 0.22 of the head's depth, some 42 mm in an adult: eyes, nose, mouth and chin lie in front of it.
// Which way the head faces is told by the trunk's axes and, where its cranium is plainly longer than wide, by
// its long axis within 45 degrees of them. What it does not do: ears, the outline of the jaw, the back of the
// head and all below the head's part stay as they are, and so does what lies inside the head.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "pipeline/export/mesh.hpp"
#include "pipeline/export/thumbnail.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct FaceCut {
  std::uint8_t head = 0;         ///< its label
  Eigen::Vector3d point, front;  ///< the plane, mm, LPS; `front` is its unit normal, out of the face
  Eigen::Matrix3d axes;          ///< columns left, back, up of the head: unit, square to each other
  Eigen::Vector3d low, high;     ///< the head's box along these axes, mm

  /// Whether a place is taken away where the head, or nothing, is.
  bool takes(const Eigen::Vector3d& place) const;
};

/// Where the face of a body ends; none where the label map has no voxel of a part named head.
std::optional<FaceCut> face_cut(const LabelMap& labels, const Landmarks& landmarks);

/// Takes the face out of a scan's copy: out of the head's label, and out of the grey values there and around.
void deface(Thumbnail& copy, const FaceCut& cut);

/// What a person is told who asked for it where there is none.
inline constexpr std::string_view no_face_found =
    "--deface: no head was found, so that no face was taken away; the report shows grey values inside the "
    "labelled "
    "parts only. Look before you share it";

/// Without a head that was found, what a copy may show: grey values where labels are, and none elsewhere.
void keep_labelled(Thumbnail& copy);

/// Makes the head's surface anew without its face. Errors: as part_meshes.
Result<void> deface(std::vector<Mesh>& meshes, const LabelMap& labels, const FaceCut& cut,
                    const MeshOptions& options);

}  // namespace borelli
