#include "pipeline/export/trajectory_csv.hpp"

#include <fmt/core.h>

#include <iterator>
#include <string>

#include "error/plain_cell.hpp"
#include "inertia/csv.hpp"
#include "pipeline/files/whole_file.hpp"

namespace borelli {
namespace {

std::vector<std::string> csv_header(const Trajectory& t) {
  std::vector<std::string> out{"time [s]"};
  const auto columns = [&](const char* what, bool positions, const char* of_angle, const char* of_length) {
    for (const CoordinateInfo& c : t.coordinates) {
      const int size = positions ? c.q_size : c.v_size;
      const char* axes = positions ? "wxyz" : "xyz";
      for (int i = 0; i < size; ++i)
        out.push_back(size == 1
                          ? fmt::format("{} {} [{}]", what, c.name, c.angle ? of_angle : of_length)
                          : fmt::format("{} {}.{} [{}]", what, c.name, axes[i], positions ? "1" : of_angle));
    }
  };
  columns("q", true, "rad", "m");
  columns("v", false, "rad/s", "m/s");
  columns("a", false, "rad/s^2", "m/s^2");
  for (const char* name : {"kinetic energy [J]", "potential energy [J]", "total energy [J]", "work [J]"})
    out.emplace_back(name);
  const auto vector = [&](const std::string& name, const char* units) {
    for (const char axis : {'x', 'y', 'z'}) out.push_back(fmt::format("{}.{} [{}]", name, axis, units));
  };
  vector("gravity centre", "m");
  if (t.linear_momentum.cols() > 0)
    vector("linear momentum", "kg m/s"), vector("angular momentum", "kg m^2/s");
  for (const auto& name : t.multiplier_names) out.push_back("multiplier " + name + " [N or N m]");
  for (const auto& name : t.contact_names) out.push_back("contact mode " + name + " [1]");
  for (const auto& name : t.contact_names) out.push_back("normal force " + name + " [N or N m]");
  for (const auto& name : t.driven_names) out.push_back("driven " + name + " [m or rad]");
  for (const auto& name : t.driven_names) out.push_back("drive effort " + name + " [N or N m]");
  for (const auto& name : t.solids) {
    vector("position " + name, "m");
    for (const char axis : {'w', 'x', 'y', 'z'})
      out.push_back(fmt::format("orientation {}.{} [1]", name, axis));
  }
  if (t.reaction_unique.cols() > 0)
    for (const auto& name : t.solids) {
      vector("reaction point " + name, "m");
      vector("reaction force " + name, "N");
      vector("reaction moment " + name, "N m");
      out.push_back("reaction unique " + name + " [1]");
    }
  out.emplace_back("trusted [1]");
  return out;
}

}  // namespace

std::vector<double> orientations(const Trajectory& t) {
  std::vector<double> out;
  out.reserve(4 * t.poses.size());
  const std::size_t row = 4 * t.solids.size();
  for (const Pose& pose : t.poses) {
    Quaternion q = quaternion(pose.R);
    if (out.size() >= row) {
      const double* before = &out[out.size() - row];
      if (q[0] * before[0] + q[1] * before[1] + q[2] * before[2] + q[3] * before[3] < 0) q = -q;
    }
    out.insert(out.end(), q.data(), q.data() + 4);
  }
  return out;
}

Result<void> write_trajectory_csv(const Trajectory& t, const std::filesystem::path& path) {
  std::string file;
  const auto header = csv_header(t);
  for (std::size_t i = 0; i < header.size(); ++i) file += (i ? "," : "") + csv_field(header[i]);
  file += '\n';

  const bool recorded = t.certificate.method == captured_method;
  const char* trusted = recorded ? "," : t.certificate.trusted ? ",1" : ",0";
  const std::vector<double> turns = orientations(t);
  for (std::size_t i = 0; i < t.times.size(); ++i) {
    fmt::format_to(std::back_inserter(file), "{:.17g}", t.times[i]);
    const auto add = [&](double value) { fmt::format_to(std::back_inserter(file), ",{:.17g}", value); };
    const auto row = static_cast<Eigen::Index>(i);
    const auto add_row = [&](const Rows& rows) {
      for (Eigen::Index c = 0; c < rows.cols(); ++c) add(rows(row, c));
    };
    add_row(t.q), add_row(t.v), add_row(t.a);
    add(t.kinetic[i]), add(t.potential[i]), add(t.kinetic[i] + t.potential[i]), add(t.work[i]);
    add_row(t.gravity_centre), add_row(t.linear_momentum), add_row(t.angular_momentum),
        add_row(t.multipliers), add_row(t.contact_modes), add_row(t.contact_forces),
        add_row(t.driven_positions), add_row(t.driven_efforts);
    for (std::size_t s = 0; s < t.solids.size(); ++s) {
      for (int c = 0; c < 3; ++c) add(t.pose(i, s).p[c]);
      for (int c = 0; c < 4; ++c) add(turns[4 * (i * t.solids.size() + s) + static_cast<std::size_t>(c)]);
    }
    for (Eigen::Index s = 0; s < t.reaction_unique.cols(); ++s) {
      for (const Rows* rows : {&t.reaction_points, &t.reaction_forces, &t.reaction_moments})
        for (Eigen::Index c = 3 * s; c < 3 * s + 3; ++c) add((*rows)(row, c));
      add(t.reaction_unique(row, s));
    }
    file += trusted;
    file += '\n';
  }
  return write_bytes(path, file);
}

}  // namespace borelli
