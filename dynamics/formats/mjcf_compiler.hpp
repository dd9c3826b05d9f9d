// MJCF's <compiler>: how to interpret the numbers of a model.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/formats/xml_element.hpp"
#include "dynamics/numbers/pose.hpp"

namespace borelli {

struct MjcfCompiler {
  enum class InertiaFromGeom { never, where_missing, always };

  bool degrees = true;  ///< angles in the file are in degrees
  std::string euler_sequence = "xyz";
  bool auto_limits = true;  ///< a joint with a range is limited
  bool align_free = false;  ///< MuJoCo puts a free leaf body's frame on its inertia
  InertiaFromGeom inertia_from_geom = InertiaFromGeom::where_missing;
  int lowest_group = 0, highest_group = 5;  ///< geom groups that count in the inertia
  bool balance_inertia = false;             ///< impossible principal moments are replaced by their mean
  bool exact_mesh_inertia = false;
  bool fit_box = false;  ///< primitives are fitted to a mesh's bounding box, not to its box of equal inertia
  double least_mass = 0, least_inertia = 0;  ///< lower bounds for every body, kg, kg m^2
  double total_mass = -1;                    ///< kg; masses and inertias are scaled to it; -1: not
  std::string mesh_folder;
  bool strip_path = false;       ///< folders in mesh file names are dropped
  std::filesystem::path folder;  ///< of the model's main file

  /// Merges all <compiler> sections of a model; later ones override earlier ones.
  static MjcfCompiler read(const XmlElement& root);

  /// An angle of the file in rad.
  double angle(double value) const;
  /// The pose of an element's frame in its parent's: `pos` and one of quat, axisangle, euler, xyaxes, zaxis.
  Pose pose_of(const XmlElement& element) const;
  Eigen::Matrix3d orientation_of(const XmlElement& element) const;
  /// The rotation by three Euler angles, in the file's unit, about the axes of `eulerseq`.
  Eigen::Matrix3d from_euler(const Eigen::Vector3d& angles) const;
};

/// The <compiler> of each model file that <attach> joins, by XmlElement::part.
struct MjcfCompilers {
  std::vector<MjcfCompiler> all;
  const MjcfCompiler& of(const XmlElement& e) const { return all[static_cast<std::size_t>(e.part)]; }
  Pose pose_of(const XmlElement& e) const { return of(e).pose_of(e); }
};

/// The smallest rotation that takes z to a direction (of any length but zero).
Eigen::Matrix3d turn_from_z(const Eigen::Vector3d& direction);

}  // namespace borelli
