// OpenSim's external loads: an XML file that says which columns of a table are the forces on which body.
//
// Source: opensim-core, OpenSim/Simulation/Model/ExternalForce.h and .cpp, ExternalLoads.cpp, and
// Storage::getColumnIndicesForIdentifier in OpenSim/Common/Storage.cpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynamics/formats/unread.hpp"
#include "error/error.hpp"
#include "pipeline/recordings/measured_force.hpp"
#include "pipeline/recordings/motion_table.hpp"

namespace borelli {

/// A force and a moment on a body. Without a force in the file: zero force. Without a moment: zero moment.
/// Without a point: the body's origin, i.e. zero in `point_body` = `body`.
struct ExternalLoad {
  std::string body;                   ///< it acts on
  std::string force_body = "ground";  ///< whose axes `measured.force` and `measured.moment` are in
  std::string point_body = "ground";  ///< whose frame `measured.point` is in
  MeasuredForce measured;
};

struct ExternalLoads {
  std::string name;
  std::filesystem::path data_file;    ///< the table
  std::vector<ExternalLoad> loads;    ///< those that act
  std::vector<std::string> disabled;  ///< names of those that do not (isDisabled, appliesForce)
  NotModelled not_modelled;
  std::vector<std::string> warnings;  ///< a sentence each
};

/// Reads an <ExternalLoads> file and its table, with or without <OpenSimDocument> around it.
///
/// An identifier is the beginning of three column names. Their order is that of the endings x, y, z or 1, 2,
/// 3 ("v" for vx, vy, vz); where the names end otherwise, that of the table, with a warning. If more than
/// three columns begin so, those with exactly such an ending after the identifier (or after a '.' or '_') are
/// meant.
///
/// `table`: a file to read instead of the one that the XML names. Errors: XML that is no external loads, or
/// of OpenSim before 2.3.1 (PrescribedForce); no table; a load without body, or without force and moment; an
/// identifier that does not find three columns; as read_motion_table.
Result<ExternalLoads> read_external_loads(const std::filesystem::path& path,
                                          const std::filesystem::path& table = {});

/// The columns of an identifier, in the order x, y, z. `in_order`: false where the endings do not say so.
/// Errors: other than three columns; `where` is the place in the XML file.
struct IdentifiedColumns {
  Eigen::Index column[3];
  bool in_order = true;
};
Result<IdentifiedColumns> identified_columns(const MotionTable& table, const std::string& identifier,
                                             const std::string& where);

}  // namespace borelli
