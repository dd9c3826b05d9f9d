// The joints of OpenSim as sequences of switches.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/formats/osim_layout.hpp"
#include "dynamics/formats/unread.hpp"
#include "dynamics/scene/switch.hpp"

namespace borelli {

/// Turns joints into switches and keeps what they say of coordinates.
class OsimJoints {
 public:
  explicit OsimJoints(NotModelled& notes) : notes_(notes) {}

  /// The motion X_PC(q) of a joint between its two frames, as switches named after the file's coordinates.
  ///
  /// The rotations of a joint are about its frame's own axes, one after the other; before them come
  /// translations along the axes of the parent's frame (Simbody's MobilizedBody::FunctionBased, which
  /// OpenSim's CustomJoint is). An axis with a coordinate of its own is a rotation or a translation; axes
  /// that one coordinate moves by functions are one guided switch. If axes of another coordinate lie between
  /// them, a coordinate `name.2` follows by a constraint. BallJoint and FreeJoint have three rotations about
  /// x, y and z, as their coordinates are Euler's angles.
  ///
  /// Throws XmlRefusal: joints and functions that are not known, and axes of several coordinates.
  std::vector<Switch> read(const OsimJoint& joint);

 private:
  struct Axis;
  struct Coordinate;
  std::vector<Axis> axes_of(const OsimJoint& joint, std::vector<Coordinate>& coordinates);
  Axis custom_axis(const OsimJoint& joint, const XmlElement* element, int number,
                   const std::vector<Coordinate>& coordinates) const;
  std::vector<Axis> custom_axes(const OsimJoint& joint, const std::vector<Coordinate>& coordinates);
  Coordinate coordinate_of(const OsimJoint& joint, std::size_t i);
  Switch switch_of(const OsimJoint& joint, std::vector<GuidedPart> parts, const Coordinate& coordinate);
  void set_motion(const Coordinate& coordinate, Switch& one);

  NotModelled& notes_;
  std::map<std::string, std::string> joint_of_coordinate_;
};

/// The inverse of a motion: its switches in reverse order, each the other way.
std::vector<Switch> inverse_motion(std::vector<Switch> switches);

}  // namespace borelli
