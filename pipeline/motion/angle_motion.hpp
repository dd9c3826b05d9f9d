// Joint angles of a table (.mot, .sto) on a scanned body: its own coordinates, or those of OpenSim's models.
#pragma once

#include <string>
#include <vector>

#include "dynamics/inverse/recorded_motion.hpp"
#include "error/error.hpp"
#include "pipeline/body/foot_soles.hpp"
#include "pipeline/recordings/motion_table.hpp"
#include "segmentation/vocabulary/landmarks.hpp"

namespace borelli {

struct AngleMotion {
  RecordedPositions positions;  ///< of the body's system; z up
  std::string root;             ///< the solid that carries the body; empty: none is free
  /// The point of the root whose path the table gives; in the root's frame, m.
  Eigen::Vector3d root_point = Eigen::Vector3d::Zero();
  std::vector<std::string> warnings;
};

/// Positions of the body at the table's times. `body`: the system of a skeleton that starts in the scan's
/// pose (build_skeleton).
///   own      Columns of the body's coordinates, as `run` and `ik` write them (positions_in).
///   OpenSim  Columns by data/coordinate_names.csv. At zero, OpenSim's models and this body stand in the
///            anatomical position, with X forwards, Y up, Z to the right (joint_axes.hpp). The ground's Y
///            becomes the world's z. Pelvis coordinates place OpenSim's pelvis origin, the middle of the two
///            ASIS; a body without these landmarks uses the middle of its hips. A joint without a column
///            stays in the anatomical position, with a warning.
/// Errors: neither kind of column; a value that is not finite; as positions_in.
Result<AngleMotion> angle_motion(const System& body, const Landmarks& landmarks, const MotionTable& table);

/// Size of the recorded person over that of the body. It is the root point's height above the floor (z = 0)
/// over its height above the body's lowest sole point at the same angles: the median over the times at which
/// the lower foot is flat (within 2 cm), or over all times if it never is. `soles`: m, the world of the
/// body's start. 1 without soles or root.
double size_by_height(const System& body, const AngleMotion& motion, const FootSoles& soles);

/// The positions of the body if it were `size` times as large, with its root point on the same path.
RecordedPositions at_size(const System& body, const AngleMotion& motion, double size);

}  // namespace borelli
