// Bodies of real anatomy that no rule's author drew: the ICRP adults bent, reshaped and scanned, with their
// truth.
//
// Labels, bones, organs, CT numbers and densities go along with the tissue (body_map, body_raster). The parts
// of the truth are the carried owners, parted by PartPlanes at the landmarks, which move as their bones do.
#pragma once

#include "tests/suite/labelled_body.hpp"
#include "tests/suite/true_scan.hpp"
#include "tests/suite/warp.hpp"

namespace borelli::suite {

using WarpedBody = TrueScan;

/// The warped body as its scanner sees it. The same arguments give the same voxels.
WarpedBody warped_body(const LabelledBody& body, const Warp& warp);

/// The body's landmarks after the motion, mm; those of what is lost too.
Landmarks moved_landmarks(const LabelledBody& body, const BodyMap& map);

/// A guess at what limbs and trunk share of one place, mm^3, from each 18th voxel; contacts at rest count
/// too.
double guessed_overlap(const LabelledBody& body, const BodyMap& map);

/// The first of six attempts whose limbs do not go through each other by more than 250 ml, or the one that
/// does so least.
Warp fitting_warp(const LabelledBody& body, std::uint64_t seed);

}  // namespace borelli::suite
