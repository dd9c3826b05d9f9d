// OpenSim's set-up of inverse kinematics: which markers and coordinates to follow, and how closely.
//
// Source: opensim-core, OpenSim/Tools/InverseKinematicsTool.h, InverseKinematicsToolBase.h, IKTask.h and
// IKCoordinateTask.cpp, whose default values are taken here.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/formats/unread.hpp"
#include "error/error.hpp"

namespace borelli {

struct MarkerTask {
  std::string marker;
  bool apply = true;
  double weight = 0;  ///< 0 or more
};

struct CoordinateTask {
  enum class Target {
    default_value,  ///< the coordinate's default in the model
    manual_value,   ///< `value`
    from_file       ///< the coordinate file's column of this name
  };
  std::string coordinate;
  bool apply = true;
  double weight = 0;  ///< 0 or more
  Target target = Target::default_value;
  double value = 0;  ///< rad or m
};

/// Paths are relative to the set-up's own folder, joined with it; empty where none is given.
struct InverseKinematicsSetup {
  std::string name;
  std::filesystem::path model_file, marker_file, coordinate_file, results_directory, output_motion_file;
  std::vector<MarkerTask> markers;                                     ///< in the order of the file
  std::vector<CoordinateTask> coordinates;                             ///< likewise
  double constraint_weight = std::numeric_limits<double>::infinity();  ///< infinite: met exactly
  double accuracy = 1e-5;
  std::pair<double, double> time_range;  ///< s; infinite: as far as the data
  bool report_errors = true, report_marker_locations = false;
  NotModelled not_modelled;  ///< elements that were not read
};

/// Reads an <InverseKinematicsTool> (or <IKTool>) file, with or without <OpenSimDocument> around it. Errors,
/// with their line: another file; the trials of OpenSim before 2.3 (IKTrialSet); a task without a name or
/// with a name that another has; weights below zero; words that are no numbers; an unknown value_type.
Result<InverseKinematicsSetup> read_ik_setup(const std::filesystem::path& path);

}  // namespace borelli
