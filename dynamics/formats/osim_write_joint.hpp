// The switches of a solid as joints of OpenSim.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/formats/omissions.hpp"
#include "dynamics/formats/osim_write_names.hpp"
#include "dynamics/scene/scene.hpp"
#include "error/error.hpp"

namespace borelli {

/// An axis of a written joint. It turns or slides by a function of one coordinate.
struct WrittenAxis {
  GuidedPart part;  ///< axis in the joint's parent frame (translation), or moved by the rotations before
  std::size_t coordinate;  ///< index into WrittenJoint::coordinates
};

/// A coordinate of a written joint.
struct WrittenCoordinate {
  std::string name;
  bool turns = true;  ///< rad, else m
  double start = 0, speed = 0;
  std::optional<Range> range;
  bool clamped = false;  ///< the range binds the coordinate
  bool locked = false;
  std::optional<TimeFunction> prescribed;  ///< of time
};

/// A joint between two frames: up to three translations, then up to three rotations. Without axes it is a
/// weld.
struct WrittenJoint {
  Pose X_PF;  ///< of the joint's parent frame in the parent body
  Pose X_MB;  ///< of the child body in the joint's child frame
  std::vector<WrittenAxis> translations, rotations;
  std::vector<WrittenCoordinate> coordinates;
};

/// A coordinate that follows another one.
struct WrittenCoupling {
  std::string on, of;  ///< as written
  TimeFunction by;
};

/// A chain of joints, with a massless body between each two of them, and the couplings of its coordinates.
struct WrittenChain {
  std::vector<WrittenJoint> joints;  ///< at least one
  std::vector<WrittenCoupling> couplings;
};

/// Writes a solid's switches as a chain of joints. One joint is enough for translations followed by
/// rotations, without a displacement between the rotations. A ball becomes three rotations about x, y and z
/// of its frame, in another order where that order starts near gimbal lock. A guided switch whose parts do
/// not fit into one joint gets a coordinate for each joint, tied to the first. Adds to `lost` what
/// OpenSim cannot hold. Errors name the solid: a guided switch by a spline that OpenSim does not have.
Result<WrittenChain> write_osim_chain(const Scene& scene, const Solid& solid, OsimNames& names,
                                      Omissions& lost);

}  // namespace borelli
