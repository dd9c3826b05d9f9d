// Reads the forces of OpenSim that a scene can hold.
#pragma once

#include <set>
#include <string>

#include "dynamics/formats/osim_frames.hpp"
#include "dynamics/formats/unique_names.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

/// Adds forces to a scene as efforts.
class OsimForceReader {
 public:
  /// `coordinates`: the names of all scalar coordinates.
  OsimForceReader(const OsimFrames& frames, std::set<std::string> coordinates, Scene& scene)
      : frames_(frames), coordinates_(std::move(coordinates)), scene_(scene) {}

  /// Reads PointToPointSpring, SpringGeneralizedForce, PrescribedForce at a fixed point, and the expressions
  /// that write_osim() makes of damped springs and of springs at limits (ExpressionBasedPointToPointForce,
  /// ExpressionBasedCoordinateForce). Leaves others unread. Throws XmlRefusal: names that are not there.
  void read(const XmlElement& e);

 private:
  void read_prescribed(const XmlElement& e);
  void add(const XmlElement& e, EffortKind kind, const std::string& ending = "");
  CoordinateName coordinate(const XmlElement& e) const;
  SolidPoint end(const XmlElement& e, const std::string& number) const;

  const OsimFrames& frames_;
  std::set<std::string> coordinates_;
  Scene& scene_;
  UniqueNames names_;
};

}  // namespace borelli
