#include "pipeline/export/trajectory_file.hpp"

#include <fmt/core.h>

#include <cmath>
#include <iterator>
#include <optional>
#include <type_traits>
#include <utility>

#include "error/plain_cell.hpp"
#include "inertia/csv.hpp"
#include "pipeline/export/certificate_report.hpp"
#include "pipeline/files/hdf5_file.hpp"
#include "pipeline/files/whole_file.hpp"

namespace borelli {
namespace {

constexpr const char* format = "borelli trajectory";

// The certificate's numbers by name, shared by writer and reader.
template <class C, class Visit>
void certificate_numbers(C& c, Visit&& visit) {
  visit("trusted", c.trusted);
  visit("reason_time", c.reason_time);
  visit("energy_drift", c.energy_drift);
  visit("energy_drift_time", c.energy_drift_time);
  visit("energy_turnover", c.energy_turnover);
  visit("energy_threshold", c.energy_threshold);
  visit("work_efforts", c.work_efforts);
  visit("work_drives", c.work_drives);
  visit("work_constraints", c.work_constraints);
  visit("work_baumgarte", c.work_baumgarte);
  visit("work_projection", c.work_projection);
  visit("work_projection_size", c.work_projection_size);
  visit("constraint_rows", c.constraint_rows);
  visit("constraint_rank", c.constraint_rank);
  visit("steps_accepted", c.steps_accepted);
  visit("steps_rejected", c.steps_rejected);
  visit("evaluations", c.evaluations);
  visit("smallest_step", c.smallest_step);
  visit("smallest_step_time", c.smallest_step_time);
}

// Numbers that older files lack.
template <class C, class Visit>
void singular_numbers(C& c, Visit&& visit) {
  visit("nearness", c.nearness);
  visit("nearness_time", c.nearness_time);
  visit("singular_passages", c.singular_passages);
  visit("singular_turn", c.singular_turn);
}

// ---- writing HDF5 ----

void write_column(Hdf5Writer& file, const std::string& name, const std::vector<double>& values,
                  const char* units) {
  file.numbers(name, {values.size()}, values.data(), units);
}

template <class T, class Field>
void write_column(Hdf5Writer& file, const std::string& name, const std::vector<T>& rows, Field T::*field,
                  const char* units = "") {
  if constexpr (std::is_same_v<Field, std::string>) {
    std::vector<std::string> texts;
    for (const T& row : rows) texts.push_back(row.*field);
    file.texts(name, texts);
  } else {
    std::vector<double> values;
    for (const T& row : rows) values.push_back(static_cast<double>(row.*field));
    write_column(file, name, values, units);
  }
}

// One row per time, also if there are no columns.
void write_rows(Hdf5Writer& file, const std::string& name, std::size_t times, const Rows& rows,
                const char* units) {
  file.numbers(name, {times, static_cast<std::size_t>(rows.cols())}, rows.data(), units);
}

// Unit quaternions of all poses; the sign is the one nearer to the same solid's previous quaternion.
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

void write_certificate(Hdf5Writer& file, const Certificate& c) {
  file.group("/certificate");
  certificate_numbers(c, [&](const char* name, auto value) {
    file.attribute("/certificate", name, static_cast<double>(value));
  });
  singular_numbers(c, [&](const char* name, auto value) {
    file.attribute("/certificate", name, static_cast<double>(value));
  });
  file.attribute("/certificate", "reason", c.reason);
  file.attribute("/certificate", "method", c.method);
  file.attribute("/certificate", "equations", c.equations);
  file.attribute("/certificate", "assembly_position", c.assembly_position);
  file.attribute("/certificate", "assembly_velocity", c.assembly_velocity);
  file.attribute("/certificate", "assembly_position_coordinate", c.assembly_position_coordinate);
  file.attribute("/certificate", "assembly_velocity_coordinate", c.assembly_velocity_coordinate);
  file.attribute("/certificate", "step_defect", c.step_defect);
  file.attribute("/certificate", "step_defect_time", c.step_defect_time);
  file.attribute("/certificate", "step_defect_coordinate", c.step_defect_coordinate);
  file.attribute("/certificate", "accuracy", c.accuracy);
  file.attribute("/certificate", "estimated_error", c.estimated_error);
  file.attribute("/certificate", "vouches_for", vouches_for(c));
  file.attribute("/certificate", "state_known_until", c.known_until);
  file.attribute("/certificate", "stiff_from", c.stiff_from);
  file.attribute("/certificate", "work_events", c.work_events);
  file.attribute("/certificate", "work_events_size", c.work_events_size);
  file.attribute("/certificate", "contacts", c.contacts);
  file.attribute("/certificate", "impacts", static_cast<double>(c.impacts));
  file.attribute("/certificate", "impact_loss", c.impact_loss);
  file.attribute("/certificate", "contact_error", c.contact_error);
  write_column(file, "/certificate/events/time", c.events, &LoggedEvent::time, "s");
  write_column(file, "/certificate/events/kind", c.events, &LoggedEvent::kind);
  write_column(file, "/certificate/events/name", c.events, &LoggedEvent::name);
  write_column(file, "/certificate/events/impulse", c.events, &LoggedEvent::impulse, "N s or N m s");
  write_column(file, "/certificate/events/energy_lost", c.events, &LoggedEvent::energy_lost, "J");
  file.texts("/certificate/redundant", c.redundant);
  file.texts("/certificate/notes", c.notes);
  write_column(file, "/certificate/conserved/name", c.conserved, &Conserved::name);
  write_column(file, "/certificate/conserved/drift", c.conserved, &Conserved::drift, "as named");
  write_column(file, "/certificate/conserved/scale", c.conserved, &Conserved::scale, "as named");
  write_column(file, "/certificate/conserved/time", c.conserved, &Conserved::time, "s");
  write_column(file, "/certificate/residuals/constraint", c.residuals, &ConstraintResidual::constraint);
  write_column(file, "/certificate/residuals/position", c.residuals, &ConstraintResidual::position,
               "m or rad");
  write_column(file, "/certificate/residuals/velocity", c.residuals, &ConstraintResidual::velocity,
               "m/s or rad/s");
  write_column(file, "/certificate/residuals/position_time", c.residuals, &ConstraintResidual::position_time,
               "s");
  write_column(file, "/certificate/residuals/velocity_time", c.residuals, &ConstraintResidual::velocity_time,
               "s");
  write_column(file, "/certificate/residuals/acceleration", c.residuals, &ConstraintResidual::acceleration,
               "m/s^2 or rad/s^2");
  write_column(file, "/certificate/residuals/acceleration_time", c.residuals,
               &ConstraintResidual::acceleration_time, "s");
}

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

// ---- reading HDF5 ----

// Reads arrays one after the other; the first error is kept and ends the reading.
class Fill {
 public:
  Fill(const Hdf5Reader& file, const std::filesystem::path& path) : file_(file), path_(path.string()) {}

  bool fine() const { return !error_; }
  const Error& error() const { return *error_; }

  std::vector<double> column(const std::string& name) {
    auto array = numbers(name, 1);
    return array.values;
  }
  std::vector<double> column(const std::string& name, std::size_t count) {
    auto values = column(name);
    expect(name, values.size(), count);
    values.resize(count);
    return values;
  }
  Rows rows(const std::string& name, std::size_t count, std::size_t columns) {
    const Hdf5Array array = numbers(name, 2);
    if (fine()) expect(name, array.shape[0], count);
    if (fine()) expect(name, array.shape[1], columns);
    if (!fine()) return {};
    return Eigen::Map<const Rows>(array.values.data(), static_cast<Eigen::Index>(count),
                                  static_cast<Eigen::Index>(columns));
  }
  Rows rows(const std::string& name, std::size_t count) {
    const Hdf5Array array = numbers(name, 2);
    return fine() ? rows(name, count, array.shape[1]) : Rows();
  }
  Hdf5Array numbers(const std::string& name, std::size_t dimensions) {
    if (!fine()) return {};
    auto array = file_.numbers(name);
    if (!array) {
      error_ = array.error();
    } else if (array->shape.size() != dimensions) {
      complain(fmt::format("{} has {} dimensions, expected {}", name, array->shape.size(), dimensions));
    } else {
      return std::move(*array);
    }
    return {};
  }
  std::vector<std::string> texts(const std::string& name) {
    if (!fine()) return {};
    auto texts = file_.texts(name);
    if (!texts) error_ = texts.error();
    return texts.value_or(std::vector<std::string>{});
  }
  std::vector<std::string> texts(const std::string& name, std::size_t count) {
    auto out = texts(name);
    expect(name, out.size(), count);
    out.resize(count);
    return out;
  }
  double attribute(const std::string& object, const std::string& name) {
    if (!fine()) return 0;
    const auto value = file_.number_attribute(object, name);
    if (!value) error_ = value.error();
    return value.value_or(0);
  }
  // For data that files of older versions lack.
  bool holds(const std::string& name) const { return file_.holds(name); }
  double attribute_if_there(const std::string& object, const std::string& name, double otherwise = 0) const {
    return file_.number_attribute(object, name).value_or(otherwise);
  }
  std::string text_attribute_if_there(const std::string& object, const std::string& name) const {
    return file_.text_attribute(object, name).value_or("");
  }
  std::string text_attribute(const std::string& object, const std::string& name) {
    if (!fine()) return {};
    const auto value = file_.text_attribute(object, name);
    if (!value) error_ = value.error();
    return value.value_or("");
  }
  // Converts a number of the file to another type; in a damaged file it may not fit.
  template <class T>
  T as(const std::string& name, double value) {
    if constexpr (std::is_same_v<T, bool>) return value != 0;
    if constexpr (std::is_integral_v<T>) {
      const double most = sizeof(T) > sizeof(int) ? 1e15 : 2e9;
      if (std::abs(value) < most) return static_cast<T>(value);
      complain(fmt::format("{} is {}, expected a whole number", name, value));
      return T{};
    } else {
      return value;
    }
  }
  void expect(const std::string& name, std::size_t found, std::size_t expected) {
    if (found != expected) complain(fmt::format("{} has {} entries, expected {}", name, found, expected));
  }
  void complain(std::string what) {
    if (fine()) error_ = Error{path_, std::move(what), Error::Kind::failure};
  }

 private:
  const Hdf5Reader& file_;
  std::string path_;
  std::optional<Error> error_;
};

template <class T, class Field>
void read_column(Fill& fill, const std::string& name, std::vector<T>& rows, Field T::*field) {
  if constexpr (std::is_same_v<Field, std::string>) {
    auto texts = fill.texts(name, rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].*field = std::move(texts[i]);
  } else {
    const auto values = fill.column(name, rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].*field = fill.as<Field>(name, values[i]);
  }
}

void read_coordinates(Fill& fill, Trajectory& t) {
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

void read_poses(Fill& fill, Trajectory& t) {
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

void read_reactions(Fill& fill, Trajectory& t) {
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

void read_certificate(Fill& fill, Certificate& c) {
  certificate_numbers(c, [&]<class T>(const char* name, T& value) {
    value = fill.as<T>(name, fill.attribute("/certificate", name));
  });
  singular_numbers(c, [&]<class T>(const char* name, T& value) {
    value = fill.as<T>(name, fill.attribute_if_there("/certificate", name));
  });
  c.reason = fill.text_attribute("/certificate", "reason");
  c.method = fill.text_attribute_if_there("/certificate", "method");
  c.equations = fill.text_attribute_if_there("/certificate", "equations");
  c.assembly_position = fill.attribute_if_there("/certificate", "assembly_position");
  c.assembly_velocity = fill.attribute_if_there("/certificate", "assembly_velocity");
  c.assembly_position_coordinate =
      fill.text_attribute_if_there("/certificate", "assembly_position_coordinate");
  c.assembly_velocity_coordinate =
      fill.text_attribute_if_there("/certificate", "assembly_velocity_coordinate");
  c.step_defect = fill.attribute_if_there("/certificate", "step_defect");
  c.step_defect_time = fill.attribute_if_there("/certificate", "step_defect_time");
  c.step_defect_coordinate = fill.text_attribute_if_there("/certificate", "step_defect_coordinate");
  c.accuracy = fill.attribute_if_there("/certificate", "accuracy");
  c.estimated_error = fill.attribute_if_there("/certificate", "estimated_error");
  c.known_until = fill.attribute_if_there("/certificate", "state_known_until", c.known_until);
  c.stiff_from = fill.attribute_if_there("/certificate", "stiff_from", c.stiff_from);
  c.work_events = fill.attribute_if_there("/certificate", "work_events");
  c.work_events_size = fill.attribute_if_there("/certificate", "work_events_size");
  c.contacts = fill.as<int>("contacts", fill.attribute_if_there("/certificate", "contacts"));
  c.impacts = fill.as<long>("impacts", fill.attribute_if_there("/certificate", "impacts"));
  c.impact_loss = fill.attribute_if_there("/certificate", "impact_loss");
  c.contact_error = fill.attribute_if_there("/certificate", "contact_error");
  if (fill.holds("/certificate/events/time")) {
    c.events.resize(fill.column("/certificate/events/time").size());
    read_column(fill, "/certificate/events/time", c.events, &LoggedEvent::time);
    read_column(fill, "/certificate/events/kind", c.events, &LoggedEvent::kind);
    read_column(fill, "/certificate/events/name", c.events, &LoggedEvent::name);
    if (fill.holds("/certificate/events/impulse")) {
      read_column(fill, "/certificate/events/impulse", c.events, &LoggedEvent::impulse);
      read_column(fill, "/certificate/events/energy_lost", c.events, &LoggedEvent::energy_lost);
    }
  }
  c.redundant = fill.texts("/certificate/redundant");
  c.notes = fill.texts("/certificate/notes");
  c.conserved.resize(fill.texts("/certificate/conserved/name").size());
  read_column(fill, "/certificate/conserved/name", c.conserved, &Conserved::name);
  read_column(fill, "/certificate/conserved/drift", c.conserved, &Conserved::drift);
  read_column(fill, "/certificate/conserved/scale", c.conserved, &Conserved::scale);
  read_column(fill, "/certificate/conserved/time", c.conserved, &Conserved::time);
  c.residuals.resize(fill.texts("/certificate/residuals/constraint").size());
  read_column(fill, "/certificate/residuals/constraint", c.residuals, &ConstraintResidual::constraint);
  read_column(fill, "/certificate/residuals/position", c.residuals, &ConstraintResidual::position);
  read_column(fill, "/certificate/residuals/velocity", c.residuals, &ConstraintResidual::velocity);
  read_column(fill, "/certificate/residuals/position_time", c.residuals, &ConstraintResidual::position_time);
  read_column(fill, "/certificate/residuals/velocity_time", c.residuals, &ConstraintResidual::velocity_time);
  if (fill.holds("/certificate/residuals/acceleration")) {
    read_column(fill, "/certificate/residuals/acceleration", c.residuals, &ConstraintResidual::acceleration);
    read_column(fill, "/certificate/residuals/acceleration_time", c.residuals,
                &ConstraintResidual::acceleration_time);
  }
}

// ---- CSV ----

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
  return out;
}

Result<void> write_csv(const Trajectory& t, const std::filesystem::path& path) {
  std::string file, text = text_of(t.certificate);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    file += plain_comment("# " + text.substr(begin, end - begin)) + '\n';
    begin = end + 1;
  }
  const auto header = csv_header(t);
  for (std::size_t i = 0; i < header.size(); ++i) file += (i ? "," : "") + csv_field(header[i]);
  file += '\n';

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
    file += '\n';
  }
  return write_bytes(path, file);
}

Result<StoredTrajectory> read_hdf5(const Hdf5Reader& file, const std::filesystem::path& path) {
  const auto found = file.text_attribute("/", "format");
  if (!found || *found != format)
    return bad_use(path.string(),
                   "is an HDF5 file, but not a trajectory: it has no attribute format = \"borelli "
                   "trajectory\"");
  Fill fill(file, path);
  if (const double version = fill.attribute("/", "version"); version != 1)
    fill.complain(fmt::format("is a trajectory of version {}, expected 1", version));

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
  const std::string ending = path.extension().string();
  if (ending == ".h5" || ending == ".hdf5") return write_hdf5(trajectory, scene, path);
  if (ending == ".csv") return write_csv(trajectory, path);
  return bad_use(path.string(), "ends in '" + ending + "'; expected .h5, .hdf5 or .csv");
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
