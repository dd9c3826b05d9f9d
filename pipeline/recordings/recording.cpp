#include "pipeline/recordings/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>

#include "error/file_ending.hpp"
#include "error/printable.hpp"
#include "pipeline/recordings/bvh_file.hpp"
#include "pipeline/recordings/bvh_motion.hpp"
#include "pipeline/recordings/c3d_file.hpp"
#include "pipeline/recordings/external_loads.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/trc_file.hpp"
#include "process/input_file.hpp"

namespace borelli {

using Eigen::Matrix3Xd;

namespace {

enum class RecordingKind { trc, c3d, bvh, other };

/// By the first bytes: C3D has its key 0x50 in the second one; TRC and BVH begin with their words.
RecordingKind kind_of(const std::filesystem::path& path) {
  std::array<char, 64> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  std::string_view text(head.data(), std::size_t(file.gcount()));
  if (text.size() > 1 && text[1] == 0x50 && text[0] >= 1 && text[0] < 32) return RecordingKind::c3d;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty() && (text[0] == ' ' || text[0] == '\t' || text[0] == '\r' || text[0] == '\n'))
    text.remove_prefix(1);
  if (text.starts_with("PathFileType")) return RecordingKind::trc;
  if (text.starts_with("HIERARCHY")) return RecordingKind::bvh;
  return RecordingKind::other;
}

Result<Recording> recording_from_bvh(const std::filesystem::path& path, double unit) {
  auto bvh = read_bvh(path);
  if (!bvh) return tl::unexpected(bvh.error());
  Recording out;
  out.warnings = bvh->warnings;
  if (unit == 0) {
    const auto guessed = guessed_bvh_unit(*bvh);
    if (!guessed)
      return bad_use(path.string(),
                     "has a skeleton whose size does not tell the unit of length; give --bvh-unit");
    unit = *guessed;
    out.warnings.push_back(
        fmt::format("the file does not state its unit of length; {} m was used (--bvh-unit)", unit));
  }
  auto markers = bvh_markers(*bvh, unit, path.string());
  if (!markers) return tl::unexpected(markers.error());
  out.markers = std::move(*markers);
  out.joint_centres = true;
  return out;
}

/// The columns of a name and three endings; empty: not all are there.
std::vector<Eigen::Index> triple(const MotionTable& table, const std::string& name) {
  std::vector<Eigen::Index> out;
  for (const char* axis : {"x", "y", "z"}) {
    const auto found = std::find(table.columns.begin(), table.columns.end(), name + axis);
    if (found == table.columns.end()) return {};
    out.push_back(found - table.columns.begin());
  }
  return out;
}

Matrix3Xd values_of(const MotionTable& table, const std::vector<Eigen::Index>& columns) {
  Matrix3Xd out(3, table.values.rows());
  for (int k = 0; k < 3; ++k) out.row(k) = table.values.col(columns[std::size_t(k)]).transpose();
  return out;
}

}  // namespace

Result<Recording> read_recording(const std::filesystem::path& path, double bvh_unit) {
  if (auto fine = check_input_file(path); !fine) return tl::unexpected(fine.error());
  switch (kind_of(path)) {
    case RecordingKind::trc: {
      auto trc = read_trc(path);
      if (!trc) return tl::unexpected(trc.error());
      return Recording{std::move(trc->motion), {}, std::move(trc->warnings), false};
    }
    case RecordingKind::c3d: {
      auto c3d = read_c3d(path);
      if (!c3d) return tl::unexpected(c3d.error());
      return Recording{std::move(c3d->markers), std::move(c3d->forces), std::move(c3d->warnings), false};
    }
    case RecordingKind::bvh:
      return recording_from_bvh(path, bvh_unit);
    case RecordingKind::other:
      break;
  }
  return bad_use(path.string(), "is not a recording of markers; give a .trc, .c3d or .bvh file");
}

Result<RecordedForces> read_forces(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  RecordedForces out;
  if (ending == ".xml") {
    auto loads = read_external_loads(path);
    if (!loads) return tl::unexpected(loads.error());
    out.warnings = loads->warnings;
    for (ExternalLoad& load : loads->loads) {
      if (load.force_body != "ground" || load.point_body != "ground")
        return bad_use(path.string(),
                       fmt::format("gives the force '{}' in the axes of a body; expected those of the ground",
                                   printable(load.measured.name)));
      out.forces.push_back(std::move(load.measured));
    }
  } else if (ending == ".mot" || ending == ".sto") {
    const auto table = read_motion_table(path);
    if (!table) return tl::unexpected(table.error());
    out.warnings = table->warnings;
    auto found = forces_in(table->table);
    if (!found) return bad_use(path.string(), found.error().what);
    out.forces = std::move(*found);
  } else {
    auto recording = read_recording(path);
    if (!recording) return tl::unexpected(recording.error());
    out.warnings = recording->warnings;
    out.up = recording->markers.up;
    out.forces = std::move(recording->forces);
  }
  if (out.forces.empty()) return bad_use(path.string(), "contains no ground forces");
  return out;
}

Result<std::vector<MeasuredForce>> forces_in(const MotionTable& table) {
  std::vector<MeasuredForce> out;
  for (const std::string& column : table.columns) {
    if (!column.ends_with("_vx")) continue;
    const std::string stem = column.substr(0, column.size() - 2);  // with its underscore
    const auto force = triple(table, stem + "v"), point = triple(table, stem + "p");
    if (force.empty() || point.empty())
      return bad_use(fmt::format("column '{}'", printable(column)),
                     fmt::format("belongs to a measured force, but not all of {}{{x,y,z}} are columns",
                                 printable(stem + (force.empty() ? "v" : "p"))));
    MeasuredForce one{stem.substr(0, stem.size() - 1), table.times, values_of(table, force),
                      values_of(table, point), Matrix3Xd::Zero(3, table.values.rows())};
    std::string turned = stem;
    if (const std::size_t at = turned.find("force"); at != std::string::npos) turned.replace(at, 5, "torque");
    for (const std::string& name : {turned, turned + "m", stem + "m"})
      if (const auto moment = triple(table, name); !moment.empty() && moment != force) {
        one.moment = values_of(table, moment);
        break;
      }
    for (Eigen::Index i = 0; i < one.force.cols(); ++i)
      if (one.force.col(i).isZero() && one.point.col(i).isZero())
        one.point.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    out.push_back(std::move(one));
  }
  if (out.empty())
    return bad_use("table of forces",
                   "has no columns whose names end in _vx, _vy and _vz; give OpenSim's external loads "
                   "(.xml), which name them");
  return out;
}

}  // namespace borelli
