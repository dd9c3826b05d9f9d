// Bends, reshapes and scans the labelled ICRP adults; returns each scan with its truth.
//
// Labels, bones, organs, CT numbers and densities are warped with the tissue (body_map, body_raster).
// Landmarks move with their bones. The true parts are the warped parts, cut by PartPlanes at the moved
// landmarks.
#pragma once

#include "tests/suite/labelled_body.hpp"
#include "tests/suite/true_scan.hpp"
#include "tests/suite/warp.hpp"

namespace borelli::suite {

using WarpedBody = TrueScan;

/// The warped body as its scanner sees it. The same arguments give the same voxels.
WarpedBody warped_body(const LabelledBody& body, const Warp& warp);

/// The body's landmarks after the motion, mm, including those of lost parts.
Landmarks moved_landmarks(const LabelledBody& body, const BodyMap& map);

/// The first of six attempts whose limbs intersect by at most 250 ml, or the one with the least intersection.
Warp fitting_warp(const LabelledBody& body, std::uint64_t seed);

}  // namespace borelli::suite
