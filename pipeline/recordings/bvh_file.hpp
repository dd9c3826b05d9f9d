// BVH: Biovision's text format of a skeleton and its motion.
//
// HIERARCHY holds one or more ROOTs. A joint has an OFFSET from its parent, CHANNELS, and further JOINTs or
// an End Site, a point at the end of a chain. MOTION holds the number of frames, the frame time and a line of
// numbers per frame: the channels' values in the order in which the file declares them. Source: M. Meredith,
// S. Maddock, "Motion capture file formats explained", University of Sheffield, CS-01-11 (2001); J. Lander,
// "Working with motion capture file formats", Game Developer, January 1998.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"

namespace borelli {

/// A position along x, y or z of the parent (file's unit), or a rotation about x, y or z (deg).
struct BvhChannel {
  bool rotation = false;
  int axis = 0;  ///< 0 to 2: x, y, z
};

struct BvhJoint {
  std::string name;  ///< of an End Site: its joint's name and "_end"
  int parent = -1;   ///< index, less than the joint's own; -1: a ROOT
  bool end_site = false;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< from the parent, in its axes, in the file's unit
  std::vector<BvhChannel> channels;                  ///< in the order of their values
};

struct BvhMotion {
  std::vector<BvhJoint> joints;       ///< in the order of the file: parents before children
  double frame_time = 0;              ///< s; 0: a skeleton without motion
  Eigen::MatrixXd values;             ///< #frames by #channels; file's unit and deg
  std::vector<std::string> warnings;  ///< a sentence each, without the file's name

  /// The first column of each joint in `values`, and one more: the number of channels.
  std::vector<Eigen::Index> first_channels() const;
};

/// Reads a BVH file. Keywords and channels may be in any letter case, in any order, with any blanks and line
/// ends; a name is the rest of its line. Rows win over the number of frames, with a warning; a file without
/// MOTION is a skeleton without frames, with a warning.
///
/// Errors, with their line: other words than the format's; braces that do not match; no OFFSET; a name twice;
/// a channel that is no position or rotation, or a position twice in one joint; another count of channels
/// than stated; a row with another count of numbers than channels; a frame time that is not above zero; cut
/// short; too large.
Result<BvhMotion> read_bvh(const std::filesystem::path& path);
Result<BvhMotion> parse_bvh(std::string_view text, const std::string& file);

/// Writes to exactly this path, depth first; each number reads back as the same double. End Sites lose their
/// names, which the format does not keep. Errors: joints that do not come after their parents, or sizes that
/// do not match; names that are empty, doubled or hold line ends or braces; numbers that are not finite; not
/// writable.
Result<void> write_bvh(const BvhMotion& motion, const std::filesystem::path& path);
Result<std::string> bvh_text(const BvhMotion& motion, const std::string& name);

}  // namespace borelli
