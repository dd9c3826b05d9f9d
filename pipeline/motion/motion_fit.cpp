#include "pipeline/motion/motion_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "dynamics/numbers/rotation_between.hpp"
#include "error/printable.hpp"
#include "pipeline/recordings/text_rows.hpp"

namespace borelli {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

template <class Named>
const Named* find_named(const std::vector<Named>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}

/// What to follow, and where the recording has it.
struct Followed {
  std::vector<FollowedMarker> markers;
  std::vector<Eigen::Index> columns;  ///< of the recording, per marker
  std::vector<FollowedCoordinate> coordinates;
  std::vector<CoordinateTask> tasks;  ///< per coordinate
  std::vector<std::string> warnings;
};

/// The markers that scene and recording share; a warning names those that only one of them has.
Result<Followed> choose_markers(const Scene& scene, const MarkerMotion& recording,
                                const std::optional<InverseKinematicsSetup>& setup) {
  Followed out;
  std::vector<std::string> not_in_model, not_recorded;
  const auto follow = [&](const std::string& name, double weight) {
    const auto column = std::find(recording.names.begin(), recording.names.end(), name);
    const Marker* marker = find_named(scene.markers, name);
    if (!marker) {
      not_in_model.push_back(name);
    } else if (column == recording.names.end()) {
      not_recorded.push_back(name);
    } else {
      out.markers.push_back({name, marker->at, weight});
      out.columns.push_back(column - recording.names.begin());
    }
  };
  if (setup) {
    for (const MarkerTask& task : setup->markers)
      if (task.apply && task.weight > 0) follow(task.marker, task.weight);
  } else {
    for (const std::string& name : recording.names) follow(name, 1);
    for (const Marker& marker : scene.markers)
      if (std::find(recording.names.begin(), recording.names.end(), marker.name) == recording.names.end())
        not_recorded.push_back(marker.name);
  }
  if (out.markers.empty())
    return bad_use("markers", scene.markers.empty() ? "the model has no markers to follow"
                              : setup
                                  ? "the set-up follows none of the markers that model and recording share; "
                                    "give one of them apply and a weight above 0"
                                  : fmt::format("the model has none of the recorded markers ({})",
                                                printable_list(recording.names)));
  if (!not_in_model.empty())
    out.warnings.push_back(
        fmt::format("not followed, because the model lacks them: {}", printable_list(not_in_model)));
  if (!not_recorded.empty())
    out.warnings.push_back(
        fmt::format("not followed, because the recording lacks them: {}", printable_list(not_recorded)));
  return out;
}

Result<void> choose_coordinates(const System& system, const MotionFitRequest& request, Followed& followed) {
  if (!request.setup) return {};
  for (const CoordinateTask& task : request.setup->coordinates) {
    if (!task.apply || task.weight == 0) continue;
    if (task.target == CoordinateTask::Target::from_file &&
        (!request.coordinate_values ||
         std::find(request.coordinate_values->columns.begin(), request.coordinate_values->columns.end(),
                   task.coordinate) == request.coordinate_values->columns.end()))
      return bad_use(
          fmt::format("coordinate task '{}'", printable(task.coordinate)),
          "takes its values from the set-up's coordinate_file, which is not given or has no such column");
    if (!find_named(system.coordinates, task.coordinate)) {
      followed.warnings.push_back(fmt::format(
          "the task for the coordinate '{}' was left out, because the model has no such free coordinate",
          printable(task.coordinate)));
      continue;
    }
    followed.coordinates.push_back({task.coordinate, task.weight});
    followed.tasks.push_back(task);
  }
  return {};
}

/// The values that coordinates are drawn to at a time.
VectorXd values_at(const System& system, const MotionFitRequest& request, const Followed& followed,
                   double t) {
  VectorXd out(Eigen::Index(followed.tasks.size()));
  for (std::size_t i = 0; i < followed.tasks.size(); ++i) {
    const CoordinateTask& task = followed.tasks[i];
    const CoordinateInfo& c = *find_named(system.coordinates, task.coordinate);
    double& value = out[Eigen::Index(i)];
    value = task.target == CoordinateTask::Target::manual_value ? task.value : system.initial.q[c.q_index];
    if (task.target != CoordinateTask::Target::from_file) continue;
    const MotionTable& table = *request.coordinate_values;
    const auto column =
        std::find(table.columns.begin(), table.columns.end(), task.coordinate) - table.columns.begin();
    const auto after = std::lower_bound(table.times.begin(), table.times.end(), t);
    const std::size_t high =
        std::min<std::size_t>(std::size_t(after - table.times.begin()), table.times.size() - 1);
    const std::size_t low = high > 0 ? high - 1 : 0;
    const double span = table.times[high] - table.times[low];
    const double share = span > 0 ? std::clamp((t - table.times[low]) / span, 0.0, 1.0) : 0;
    value = (1 - share) * table.values(Eigen::Index(low), column) +
            share * table.values(Eigen::Index(high), column);
    if (table.in_degrees && c.angle) value *= std::numbers::pi / 180;
  }
  return out;
}

/// Other orientations of the root bodies, to start from if the first frame is far from the scene's initial
/// pose.
std::vector<VectorXd> other_starts(const System& system) {
  std::vector<VectorXd> starts;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
  for (int i = 0; i < 32; ++i) {
    VectorXd q = system.initial.q;
    for (std::size_t b = 1; b < system.bodies.size(); ++b) {
      const Body& body = system.bodies[b];
      if (body.parent != 0) continue;
      for (int s = body.first_step; s < body.first_step + body.step_count; ++s) {
        const SwitchStep& step = system.steps[std::size_t(s)];
        if (step.drive >= 0 || !step.rotates) continue;
        if (step.nq == 1) {
          q[step.q] = angle(random);
        } else {
          Eigen::Vector4d turn{normal(random), normal(random), normal(random), normal(random)};
          q.segment<4>(step.q) = turn.normalized();
        }
      }
    }
    starts.push_back(q);
  }
  return starts;
}

/// Brings angles of simple hinges within half a turn of where they start.
void unwind(const System& system, VectorXd& q) {
  for (const CoordinateInfo& c : system.coordinates)
    if (c.kind == "rotation")
      q[c.q_index] = system.initial.q[c.q_index] +
                     std::remainder(q[c.q_index] - system.initial.q[c.q_index], 2 * std::numbers::pi);
}

/// The fit of the first frame from the scene's initial positions. If it is far from the markers (a fiftieth
/// of the scene's size), the best of fits from other attitudes that is nearer by half.
Result<VectorXd> find_start(const System& system, MarkerFit& fit, double t, const Matrix3Xd& measured,
                            const VectorXd& values) {
  VectorXd best = system.initial.q;
  auto frame = fit.fit(t, measured, values, best);
  if (!frame) return tl::unexpected(frame.error());
  unwind(system, best);
  if (frame->rms <= system.length / 50) return best;
  double least = frame->rms / 2;
  for (VectorXd& q : other_starts(system)) {
    const auto other = fit.fit(t, measured, values, q);
    if (!other || !(other->rms < least)) continue;
    least = other->rms;
    best = q;
    unwind(system, best);
  }
  return best;
}

std::vector<std::string> columns_of(const System& system) {
  std::vector<std::string> out;
  for (const CoordinateInfo& c : system.coordinates) {
    if (c.q_size == 1) {
      out.push_back(c.name);
      continue;
    }
    for (const char* part : {".w", ".x", ".y", ".z"}) out.push_back(c.name + part);
  }
  return out;
}

void warn_of_frames(const System& system, const MotionFit& fit, std::vector<std::string>& warnings) {
  std::size_t unfinished = 0;
  std::vector<int> at_end(std::size_t(system.nv), 0);
  for (const MarkerFrame& frame : fit.frames) {
    unfinished += !frame.converged;
    for (int u : frame.at_range) ++at_end[std::size_t(u)];
  }
  if (unfinished > 0)
    warnings.push_back(
        fmt::format("the fit did not converge in {} of {} frames; the best positions found were kept",
                    unfinished, fit.frames.size()));
  for (int u = 0; u < system.nv; ++u)
    if (at_end[std::size_t(u)] > 0)
      warnings.push_back(fmt::format("{} is at an end of its range in {} of {} frames",
                                     system.velocity_name(u), at_end[std::size_t(u)], fit.frames.size()));
}

}  // namespace

double MotionFit::rms() const {
  double squares = 0;
  long seen = 0;
  for (const MarkerFrame& frame : frames) {
    squares += frame.rms * frame.rms * frame.seen;
    seen += frame.seen;
  }
  return seen > 0 ? std::sqrt(squares / double(seen)) : 0;
}

Matrix3d turn_to_scene(const Scene& scene, const std::optional<Vector3d>& up) {
  if (!up || scene.gravity.norm() == 0) return Matrix3d::Identity();
  return rotation_between(*up, -scene.gravity);
}

Result<MotionFit> fit_motion(const Scene& scene, const System& system, const MarkerMotion& recording,
                             const MotionFitRequest& request) {
  auto followed = choose_markers(scene, recording, request.setup);
  if (!followed) return tl::unexpected(followed.error());
  if (auto chosen = choose_coordinates(system, request, *followed); !chosen)
    return tl::unexpected(chosen.error());
  auto fit =
      MarkerFit::create(system, followed->markers, followed->coordinates,
                        {.tolerance = 1e-8, .most_iterations = 100, .rest_weights = request.rest_weights});
  if (!fit) return tl::unexpected(fit.error());

  MotionFit out;
  out.warnings = followed->warnings;
  for (const FollowedMarker& marker : followed->markers) out.markers.push_back(marker.name);
  const Matrix3d turn = turn_to_scene(scene, recording.up);
  Matrix3Xd measured(3, Eigen::Index(followed->columns.size()));
  std::vector<VectorXd> rows;
  VectorXd q;
  std::size_t unseen = 0, in_range = 0;
  for (std::size_t f = 0; f < recording.times.size(); ++f) {
    const double t = recording.times[f];
    if (t < request.time_range.first - 1e-9 || t > request.time_range.second + 1e-9) continue;
    ++in_range;
    for (std::size_t m = 0; m < followed->columns.size(); ++m)
      measured.col(Eigen::Index(m)) = turn * recording.frames[f].col(followed->columns[m]);
    if (!(measured.array() == measured.array()).any()) {
      ++unseen;
      continue;
    }
    const VectorXd values = values_at(system, request, *followed, t);
    if (q.size() == 0) {
      auto start = find_start(system, *fit, t, measured, values);
      if (!start) return tl::unexpected(start.error());
      q = *start;
    }
    auto frame = fit->fit(t, measured, values, q);
    if (!frame) return tl::unexpected(frame.error());
    if (out.frames.empty())
      if (const auto names = fit->undetermined(); !names.empty())
        out.warnings.push_back(fmt::format("no followed marker determines {}; they keep their initial values",
                                           printable_list(names)));
    out.times.push_back(t);
    rows.push_back(q);
    out.frames.push_back(std::move(*frame));
    if (request.progress) request.progress(double(f + 1) / double(recording.times.size()));
  }
  if (out.times.empty())
    return bad_use("markers", in_range == 0 ? "no frame of the recording lies within the time range"
                                            : "no frame of the recording shows a marker of the model");
  if (unseen > 0)
    out.warnings.push_back(
        fmt::format("left out {} of {} frames, which show no marker of the model", unseen, in_range));
  out.left_out = unseen;
  out.q.resize(Eigen::Index(rows.size()), system.nq);
  out.errors.resize(Eigen::Index(rows.size()), measured.cols());
  for (std::size_t f = 0; f < rows.size(); ++f) {
    out.q.row(Eigen::Index(f)) = rows[f].transpose();
    out.errors.row(Eigen::Index(f)) = out.frames[f].errors.transpose();
  }
  warn_of_frames(system, out, out.warnings);
  return out;
}

std::string misfit(double rms, const MarkerMotion& recording) {
  constexpr double far = 0.08;  // of the spread: 40 mm on an adult, twice what is usual
  double squares = 0;
  Eigen::Index count = 0;
  for (const Matrix3Xd& frame : recording.frames) {
    Matrix3Xd seen(3, frame.cols());
    Eigen::Index n = 0;
    for (Eigen::Index m = 0; m < frame.cols(); ++m)
      if (frame.col(m).allFinite()) seen.col(n++) = frame.col(m);
    if (n == 0) continue;
    const Vector3d middle = seen.leftCols(n).rowwise().mean();
    squares += (seen.leftCols(n).colwise() - middle).squaredNorm();
    count += n;
  }
  const double spread = count > 0 ? std::sqrt(squares / double(count)) : 0;
  if (spread == 0 || !(rms > far * spread)) return "";  // one marker has no spread to compare with
  return fmt::format(
      "the markers lie {:.0f} mm from the model's (root mean square), {:.0f} % of their spread; up to 20 mm "
      "is advised (Hicks and others, Journal of Biomechanical Engineering 137, 2015): the recording's unit, "
      "its axes, left and right, or the markers' names may be wrong, or the model has another size",
      1e3 * rms, 100 * rms / spread);
}

MotionTable table_of(const System& system, const MotionFit& fit) {
  MotionTable table{"Coordinates", columns_of(system), fit.times, fit.q, true};
  for (const CoordinateInfo& c : system.coordinates)
    if (c.angle && c.q_size == 1) table.values.col(c.q_index) *= 180 / std::numbers::pi;
  return table;
}

MotionTable error_table_of(const MotionFit& fit) {
  MotionTable table{"Marker errors",
                    {"total_squared_error", "marker_error_RMS", "marker_error_max"},
                    fit.times,
                    Eigen::MatrixXd(Eigen::Index(fit.times.size()), Eigen::Index(3 + fit.markers.size())),
                    false};
  for (const std::string& name : fit.markers) table.columns.push_back(name);
  for (std::size_t f = 0; f < fit.frames.size(); ++f) {
    const MarkerFrame& frame = fit.frames[f];
    const auto row = Eigen::Index(f);
    table.values(row, 0) = frame.rms * frame.rms * frame.seen;
    table.values(row, 1) = frame.rms;
    table.values(row, 2) = frame.worst >= 0 ? frame.errors[frame.worst] : std::nan("");
  }
  table.values.rightCols(fit.errors.cols()) = fit.errors;
  return table;
}

}  // namespace borelli
