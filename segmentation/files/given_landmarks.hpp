// Landmarks that a person placed or corrected: our own JSON, or the points of 3D Slicer.
//
// A point's name selects the landmark of landmarks.hpp. Letter case, separators and word order do not matter,
// and L and R stand for left and right ("Hip-Left", "hip l", "LeftHip").
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct GivenLandmarks {
  Landmarks landmarks;  ///< placed or moved by a person
  /// Points of 3D Slicer that still lie where an earlier run found them. A run that finds landmarks itself
  /// need not take these.
  Landmarks unmoved;
  std::vector<std::string> warnings;  ///< unknown names, points that were not placed

  Landmarks all() const;  ///< both
};

/// Reads landmarks. Formats by extension: 3D Slicer's .mrk.json (markups; also a .json that holds them) and
/// .fcsv, in LPS or RAS and mm; else our own JSON (landmarks_file.hpp). Points of 3D Slicer get a deviation
/// of 3 mm, and the radius that write_markups noted. Points within 0.01 mm of their noted position count as
/// not moved and keep the noted source and deviation. Errors: as read_landmarks; another coordinate system or
/// unit; a repeated landmark; no point with a landmark's name.
Result<GivenLandmarks> read_given_landmarks(const std::string& path);

/// Writes landmarks as 3D Slicer's point list (.mrk.json, LPS, mm), to view and correct there. Each point's
/// description says how it was found and where; for names in `given`, where it was given. Errors: not
/// writable.
Result<void> write_markups(const std::string& path, const Landmarks& landmarks,
                           const std::vector<std::string>& given = {});

/// The landmark that a name stands for; empty if unknown.
std::string landmark_of(std::string_view name);

/// Warnings about given landmarks far from what the scan shows: far from the found landmark of the same name,
/// or nearer to that of the other side.
std::vector<std::string> doubts_of_given(const Landmarks& given, const Landmarks& found);

/// Replaces found landmarks by given ones. A landmark within 0.01 mm of the found one was not moved and stays
/// as found. One without a radius keeps that of the sphere or cylinder found there. A shoulder without any
/// radius gets that of a mean humeral head, 24 mm (Iannotti et al. 1992, J Bone Joint Surg 74-A:491), which
/// its plane needs.
void put_given(const Landmarks& given, Landmarks& landmarks);

}  // namespace borelli
