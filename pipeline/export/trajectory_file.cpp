#include "pipeline/export/trajectory_file.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "error/file_ending.hpp"
#include "pipeline/export/certificate_hdf5.hpp"
#include "pipeline/export/hdf5_columns.hpp"
#include "pipeline/export/trajectory_csv.hpp"
#include "pipeline/files/hdf5_file.hpp"

namespace borelli {
namespace {

constexpr const char* format = "borelli trajectory";

void write_reactions(Hdf5Writer& file, const Trajectory& t) {
  const std::vector<std::size_t> shape{t.times.size(), t.solids.size(), 3};
  file.numbers("/reactions/point", shape, t.reaction_points.data(), "m");
  file.numbers("/reactions/force", shape, t.reaction_forces.data(), "N");
  file.numbers("/reactions/moment", shape, t.reaction_moments.data(), "N m");
  write_rows(file, "/reactions/unique", t.times.size(), t.reaction_unique, "1");
}

Result<void> write_hdf5(const Trajectory& t, const std::string& scene, const std::filesystem::path& path) {
  Hdf5Writer file(path);
  file.attribute("/", "format", format);
  file.attribute("/", "version", 1);
  file.texts("/scene", {scene});
  write_column(file, "/time", t.times, "s");
  write_rows(file, "/q", t.times.size(), t.q, "m, rad, or a quaternion's components");
  write_rows(file, "/v", t.times.size(), t.v, "m/s or rad/s");
  write_rows(file, "/a", t.times.size(), t.a, "m/s^2 or rad/s^2");
  write_column(file, "/coordinates/name", t.coordinates, &CoordinateInfo::name);
  write_column(file, "/coordinates/kind", t.coordinates, &CoordinateInfo::kind);
  write_column(file, "/coordinates/solid", t.coordinates, &CoordinateInfo::solid);
  write_column(file, "/coordinates/q_index", t.coordinates, &CoordinateInfo::q_index, "1");
  write_column(file, "/coordinates/q_size", t.coordinates, &CoordinateInfo::q_size, "1");
  write_column(file, "/coordinates/v_index", t.coordinates, &CoordinateInfo::v_index, "1");
  write_column(file, "/coordinates/v_size", t.coordinates, &CoordinateInfo::v_size, "1");
  write_column(file, "/coordinates/angle", t.coordinates, &CoordinateInfo::angle, "1");

  file.texts("/solids/name", t.solids);
  std::vector<double> positions;
  for (const Pose& pose : t.poses) positions.insert(positions.end(), pose.p.data(), pose.p.data() + 3);
  file.numbers("/solids/position", {t.times.size(), t.solids.size(), 3}, positions.data(), "m");
  file.numbers("/solids/orientation", {t.times.size(), t.solids.size(), 4}, orientations(t).data(), "1");
  write_rows(file, "/gravity_centre", t.times.size(), t.gravity_centre, "m");
  if (t.linear_momentum.cols() > 0) {
    write_rows(file, "/momentum/linear", t.times.size(), t.linear_momentum, "kg m/s");
    write_rows(file, "/momentum/angular", t.times.size(), t.angular_momentum, "kg m^2/s");
  }
  if (t.reaction_unique.cols() > 0) write_reactions(file, t);

  file.texts("/constraints/name", t.multiplier_names);
  write_rows(file, "/constraints/multiplier", t.times.size(), t.multipliers, "N or N m");
  file.texts("/contacts/name", t.contact_names);
  write_rows(file, "/contacts/mode", t.times.size(), t.contact_modes, "1");
  write_rows(file, "/contacts/normal_force", t.times.size(), t.contact_forces, "N or N m");
  file.texts("/driven/name", t.driven_names);
  write_rows(file, "/driven/position", t.times.size(), t.driven_positions, "m or rad");
  write_rows(file, "/driven/effort", t.times.size(), t.driven_efforts, "N or N m");
  write_column(file, "/energy/kinetic", t.kinetic, "J");
  write_column(file, "/energy/potential", t.potential, "J");
  write_column(file, "/energy/work", t.work, "J");
  write_column(file, "/steps/time", t.step_times, "s");
  write_column(file, "/steps/size", t.step_sizes, "s");
  write_certificate(file, t.certificate);
  return file.close();
}

void read_coordinates(Hdf5Fill& fill, Trajectory& t) {
  t.coordinates.resize(fill.texts("/coordinates/name").size());
  read_column(fill, "/coordinates/name", t.coordinates, &CoordinateInfo::name);
  read_column(fill, "/coordinates/kind", t.coordinates, &CoordinateInfo::kind);
  read_column(fill, "/coordinates/solid", t.coordinates, &CoordinateInfo::solid);
  read_column(fill, "/coordinates/q_index", t.coordinates, &CoordinateInfo::q_index);
  read_column(fill, "/coordinates/q_size", t.coordinates, &CoordinateInfo::q_size);
  read_column(fill, "/coordinates/v_index", t.coordinates, &CoordinateInfo::v_index);
  read_column(fill, "/coordinates/v_size", t.coordinates, &CoordinateInfo::v_size);
  read_column(fill, "/coordinates/angle", t.coordinates, &CoordinateInfo::angle);
  for (const CoordinateInfo& c : t.coordinates) {
    const bool fits = c.q_index >= 0 && c.q_size >= 0 && c.q_index + c.q_size <= t.q.cols() &&
                      c.v_index >= 0 && c.v_size >= 0 && c.v_index + c.v_size <= t.v.cols();
    if (!fits) fill.complain("the coordinate " + c.name + " lies outside /q or /v");
  }
}

void read_poses(Hdf5Fill& fill, Trajectory& t) {
  t.solids = fill.texts("/solids/name");
  const Hdf5Array p = fill.numbers("/solids/position", 3), q = fill.numbers("/solids/orientation", 3);
  const std::vector<std::size_t> shape{t.times.size(), t.solids.size()};
  if (!fill.fine()) return;
  if (p.shape != std::vector{shape[0], shape[1], std::size_t{3}} ||
      q.shape != std::vector{shape[0], shape[1], std::size_t{4}})
    return fill.complain("/solids does not have one pose per time and solid");
  t.poses.resize(shape[0] * shape[1]);
  for (std::size_t i = 0; i < t.poses.size(); ++i) {
    t.poses[i].p = Eigen::Map<const Eigen::Vector3d>(&p.values[3 * i]);
    const Quaternion turn = Eigen::Map<const Quaternion>(&q.values[4 * i]);
    if (!(std::abs(turn.norm() - 1) < 1e-6))
      return fill.complain("/solids/orientation has a quaternion that is not of unit length");
    t.poses[i].R = rotation_matrix(turn);
  }
}

void read_reactions(Hdf5Fill& fill, Trajectory& t) {
  if (!fill.holds("/reactions/force")) return;
  const std::vector<std::size_t> shape{t.times.size(), t.solids.size(), 3};
  const auto vectors = [&](const std::string& name) -> Rows {
    const Hdf5Array array = fill.numbers(name, 3);
    if (!fill.fine()) return {};
    if (array.shape != shape) {
      fill.complain(name + " does not have one vector per time and solid");
      return {};
    }
    return Eigen::Map<const Rows>(array.values.data(), static_cast<Eigen::Index>(shape[0]),
                                  static_cast<Eigen::Index>(3 * shape[1]));
  };
  t.reaction_points = vectors("/reactions/point");
  t.reaction_forces = vectors("/reactions/force");
  t.reaction_moments = vectors("/reactions/moment");
  t.reaction_unique = fill.rows("/reactions/unique", t.times.size(), t.solids.size());
}

Result<StoredTrajectory> read_hdf5(const Hdf5Reader& file, const std::filesystem::path& path) {
  const auto found = file.text_attribute("/", "format");
  if (!found || *found != format)
    return bad_use(path.string(),
                   "is an HDF5 file, but not a trajectory: it has no attribute format = \"borelli "
                   "trajectory\"");
  Hdf5Fill fill(file, path);
  if (const double version = fill.attribute("/", "version"); version != 1)
    fill.complain(fmt::format("is a trajectory of version {}, but this program reads version 1", version));

  StoredTrajectory out;
  Trajectory& t = out.trajectory;
  for (auto& text : fill.texts("/scene", 1)) out.scene = std::move(text);
  t.times = fill.column("/time");
  const std::size_t n = t.times.size();
  t.q = fill.rows("/q", n);
  t.v = fill.rows("/v", n);
  t.a = fill.rows("/a", n, static_cast<std::size_t>(t.v.cols()));
  read_coordinates(fill, t);
  read_poses(fill, t);
  t.gravity_centre = fill.rows("/gravity_centre", n, 3);
  if (fill.holds("/momentum/linear")) {
    t.linear_momentum = fill.rows("/momentum/linear", n, 3);
    t.angular_momentum = fill.rows("/momentum/angular", n, 3);
  }
  read_reactions(fill, t);
  t.multiplier_names = fill.texts("/constraints/name");
  t.multipliers = fill.rows("/constraints/multiplier", n, t.multiplier_names.size());
  t.contact_modes = t.contact_forces = Rows(static_cast<Eigen::Index>(n), 0);
  if (fill.holds("/contacts/name")) {
    t.contact_names = fill.texts("/contacts/name");
    t.contact_modes = fill.rows("/contacts/mode", n, t.contact_names.size());
    t.contact_forces = fill.rows("/contacts/normal_force", n, t.contact_names.size());
  }
  t.driven_names = fill.texts("/driven/name");
  t.driven_positions = fill.rows("/driven/position", n, t.driven_names.size());
  t.driven_efforts = fill.rows("/driven/effort", n, t.driven_names.size());
  t.kinetic = fill.column("/energy/kinetic", n);
  t.potential = fill.column("/energy/potential", n);
  t.work = fill.column("/energy/work", n);
  t.step_times = fill.column("/steps/time");
  t.step_sizes = fill.column("/steps/size", t.step_times.size());
  read_certificate(fill, t.certificate);
  if (!fill.fine()) return tl::unexpected(fill.error());
  return out;
}

}  // namespace

Result<void> write_trajectory(const Trajectory& trajectory, const std::string& scene,
                              const std::filesystem::path& path) {
  if (auto known = expect_ending(path.string(), {".h5", ".hdf5", ".csv"}); !known) return known;
  return ending_of(path) == ".csv" ? write_trajectory_csv(trajectory, path)
                                   : write_hdf5(trajectory, scene, path);
}

Result<StoredTrajectory> read_trajectory(const std::filesystem::path& path) {
  StoredTrajectory stored;
  const auto done = Hdf5Reader::read(path, [&](const Hdf5Reader& file) -> Result<void> {
    auto read = read_hdf5(file, path);
    if (!read) return tl::unexpected(read.error());
    stored = std::move(*read);
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  return stored;
}

bool is_trajectory(const std::filesystem::path& path) {
  bool is = false;
  static_cast<void>(Hdf5Reader::read(path, [&](const Hdf5Reader& file) -> Result<void> {
    is = file.text_attribute("/", "format").value_or("") == format;
    return {};
  }));
  return is;
}

}  // namespace borelli
