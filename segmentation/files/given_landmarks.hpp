// Landmarks that a person placed or mended: our own JSON, or the points of 3D Slicer.
//
// A point counts for the landmark of landmarks.hpp whose name it bears; letters' case, what separates the
// words and their order do not matter, and L and R stand for left and right ("Hip-Left", "hip l", "LeftHip").
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "error/error.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct GivenLandmarks {
  Landmarks landmarks;  ///< placed or moved by a person
  /// Points of 3D Slicer that stand where an earlier run found them, as that run had them: what finds points
  /// itself need not take these.
  Landmarks unmoved;
  std::vector<std::string> warnings;  ///< names that are none of ours, points that were not placed

  Landmarks all() const;  ///< both
};

/// By the file's ending: .mrk.json (markups; also a .json that holds them) and .fcsv of 3D Slicer, in LPS or
/// RAS and mm, else our own JSON (landmarks_file.hpp). Points of 3D Slicer get a deviation of 3 mm, and the
/// radius that write_markups noted with them; those that were not moved (within 0.01 mm of where the note has
/// them) keep the noted source and deviation. Errors: as read_landmarks; another coordinate system or unit; a
/// landmark placed twice; no point that bears a landmark's name.
Result<GivenLandmarks> read_given_landmarks(const std::string& path);

/// Landmarks as 3D Slicer's point list (.mrk.json, LPS, mm), to look at and mend there; in each point's
/// description how it was found and where, or, of the names in `given`, where it was given. Errors: not
/// writable.
Result<void> write_markups(const std::string& path, const Landmarks& landmarks,
                           const std::vector<std::string>& given = {});

/// The landmark that a name stands for; empty where it is none of ours.
std::string landmark_of(std::string_view name);

/// What is to be said of landmarks that were given and lie far from what the scan shows: beside those found
/// of the same name, or nearer to those of the other side.
std::vector<std::string> doubts_of_given(const Landmarks& given, const Landmarks& found);

/// Puts landmarks that were given in the place of those found. One that lies where it was found (within 0.01
/// mm) was not moved and stays as found; one without a radius keeps that of the ball or cylinder found there.
/// A shoulder without any gets that of a mean humeral head, 24 mm (Iannotti et al. 1992, J Bone Joint Surg
/// 74-A:491), which its plane needs.
void put_given(const Landmarks& given, Landmarks& landmarks);

}  // namespace borelli
