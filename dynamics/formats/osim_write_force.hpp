// Writes the efforts and constraints of a scene that OpenSim can hold, and the shapes of its contacts.
#pragma once

#include <string>

#include "dynamics/formats/omissions.hpp"
#include "dynamics/formats/osim_write_names.hpp"
#include "dynamics/formats/xml_text.hpp"
#include "dynamics/scene/scene.hpp"

namespace borelli {

/// Adds to the objects of a ForceSet the efforts that act in OpenSim as in the scene: point springs
/// (PointToPointSpring; with a damper ExpressionBasedPointToPointForce), springs of coordinates
/// (SpringGeneralizedForce), limit springs of scalar coordinates (ExpressionBasedCoordinateForce), forces and
/// torques (PrescribedForce). Names the others in `lost`.
void write_osim_forces(const Scene& scene, const OsimNames& names, XmlNode& objects, Omissions& lost);

/// The same for the objects of a ConstraintSet: PointConstraint, PointOnLineConstraint, WeldConstraint,
/// ConstantDistanceConstraint, CoordinateCouplerConstraint.
void write_osim_constraints(const Scene& scene, const OsimNames& names, XmlNode& objects, Omissions& lost);

/// dependent = by(independent); both as written.
void write_osim_coupler(XmlNode& objects, const std::string& name, const std::string& on,
                        const std::string& of, const TimeFunction& by);

/// The spheres and half spaces of the contacts, for the objects of a ContactGeometrySet. OpenSim's contact
/// laws differ, so the contacts themselves are named in `lost`.
void write_osim_contact_shapes(const Scene& scene, const OsimNames& names, XmlNode& objects);

/// Three numbers, separated by blanks.
std::string osim_vector_text(const Eigen::Vector3d& v);
/// The angles of osim_rotation() (osim_frames.hpp), rad, as text.
std::string osim_angles_text(const Eigen::Matrix3d& R);

/// <PhysicalOffsetFrame> at a pose in the frame of this path; returns it.
XmlNode& write_osim_frame(XmlNode& holder, const std::string& name, const std::string& path, const Pose& X);

}  // namespace borelli
