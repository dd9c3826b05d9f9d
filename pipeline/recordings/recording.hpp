// A recording of a motion laboratory from any of its files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "error/error.hpp"
#include "pipeline/recordings/marker_motion.hpp"
#include "pipeline/recordings/measured_force.hpp"
#include "pipeline/recordings/motion_table.hpp"

namespace borelli {

struct Recording {
  MarkerMotion markers;
  std::vector<MeasuredForce> forces;  ///< of C3D's force plates
  std::vector<std::string> warnings;
  bool joint_centres = false;  ///< the markers are joints of a BVH skeleton
};

/// Reads markers from TRC or C3D, or joint centres from BVH; the content decides the format. `bvh_unit`:
/// BVH's unit in metres; 0: guessed, with a warning. Errors: those of the readers, and a file of another
/// kind.
Result<Recording> read_recording(const std::filesystem::path& path, double bvh_unit = 0);

struct RecordedForces {
  std::vector<MeasuredForce> forces;
  std::optional<Eigen::Vector3d> up;  ///< as MarkerMotion::up
  std::vector<std::string> warnings;
};

/// Reads ground forces: a table (.mot, .sto; see forces_in), OpenSim's external loads (.xml; the forces
/// alone, not the bodies that it names), or the plates of a C3D file. Errors: no force; external loads in the
/// axes of a body.
Result<RecordedForces> read_forces(const std::filesystem::path& path);

/// Force plates in a table without a set-up that says which columns they are: each triple whose names end in
/// "_vx", "_vy", "_vz" is a force; its point ends in "_px" ...; its moment has "torque" for "force" and ends
/// in "_x" ... or "_mx" .... Without moments they are zero. Where force and point are zero, the point is not
/// known. Errors: no such triple; a force without a point.
Result<std::vector<MeasuredForce>> forces_in(const MotionTable& table);

}  // namespace borelli
