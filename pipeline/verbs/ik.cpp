// borelli ik MODEL --motion W.trc -o W.mot: joint angles of a recorded motion, by inverse kinematics.
#include <fmt/core.h>

#include <chrono>

#include "error/file_ending.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/motion/motion_text.hpp"
#include "pipeline/motion/recorded_trajectory.hpp"
#include "pipeline/recordings/motion_table_file.hpp"
#include "pipeline/recordings/recording.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

struct IkOptions {
  std::string model, motion, setup, output, errors;
  ModelOptions how;
  std::optional<double> from, to;
  double unit = 0;
};

/// The set-up's tasks and files; the command line wins.
Result<void> use_setup(IkOptions& o, MotionFitRequest& request, const Command& command) {
  if (o.setup.empty()) return {};
  auto setup = read_ik_setup(o.setup);
  if (!setup) return tl::unexpected(setup.error());
  for (const auto* lines : {&setup->not_modelled.motion, &setup->not_modelled.other})
    for (const std::string& line : *lines) command.note(fmt::format("{}: not used: {}", o.setup, line));
  request.time_range = setup->time_range;
  if (o.motion.empty()) o.motion = setup->marker_file.string();
  request.setup = std::move(*setup);
  return {};
}

json answer_of(const IkOptions& o, const MotionFit& fit, double seconds) {
  double largest = 0;
  std::size_t frame = 0;
  for (std::size_t f = 0; f < fit.frames.size(); ++f)
    if (const MarkerFrame& one = fit.frames[f]; one.worst >= 0 && one.errors[one.worst] > largest) {
      largest = one.errors[one.worst];
      frame = f;
    }
  long iterations = 0;
  for (const MarkerFrame& one : fit.frames) iterations += one.iterations;
  json markers = json::object();
  for (std::size_t m = 0; m < fit.markers.size(); ++m) {
    double squares = 0;
    long seen = 0;
    for (const double error : fit.errors.col(Eigen::Index(m)))
      if (std::isfinite(error)) {
        squares += error * error;
        ++seen;
      }
    markers[fit.markers[m]] = seen > 0 ? json(std::sqrt(squares / double(seen))) : json();
  }
  json answer{{"model", o.model},
              {"frames", fit.frames.size()},
              {"marker_error_rms", fit.rms()},
              {"marker_error_rms_by_marker", markers},
              {"iterations_per_frame", double(iterations) / double(fit.frames.size())},
              {"milliseconds_per_frame", 1e3 * seconds / double(fit.frames.size())}};
  if (fit.frames[frame].worst >= 0)
    answer["marker_error_max"] = {{"error", largest},
                                  {"marker", fit.markers[std::size_t(fit.frames[frame].worst)]},
                                  {"time", fit.times[frame]}};
  if (!o.output.empty()) answer["output"] = o.output;
  return answer;
}

Result<json> work(IkOptions o, const Command& command) {
  MotionFitRequest request;
  if (auto used = use_setup(o, request, command); !used) return tl::unexpected(used.error());
  if (o.motion.empty()) return bad_use("ik", "needs --motion FILE, or a --setup that names one");
  for (const std::string& out : {o.output, o.errors})
    if (!out.empty())
      if (auto fine = check_writable(out, {o.model, o.motion, o.setup}); !fine)
        return tl::unexpected(fine.error());
  if (!o.output.empty())
    if (auto known = expect_ending(o.output, {".mot", ".sto", ".bvh", ".trc"}); !known)
      return tl::unexpected(known.error());
  if (!o.errors.empty())
    if (auto known = expect_ending(o.errors, {".sto", ".mot"}); !known) return tl::unexpected(known.error());
  if (o.unit > 0 && ending_of(o.motion) != ".bvh")
    return bad_use("--bvh-unit", "applies only to a motion in .bvh; leave it out");
  if (o.from) request.time_range.first = *o.from;
  if (o.to) request.time_range.second = *o.to;
  const auto model = read_model(command, o.model, o.how);
  if (!model) return tl::unexpected(model.error());
  const auto system = compile(model->scene);
  if (!system) return in_file(o.model, system.error());
  const auto recording = read_recording(o.motion, o.unit);
  if (!recording) return tl::unexpected(recording.error());
  command.warn(recording->warnings);
  if (request.setup) {
    const auto& tasks = request.setup->coordinates;
    const bool from_file = std::any_of(tasks.begin(), tasks.end(), [](const CoordinateTask& task) {
      return task.apply && task.target == CoordinateTask::Target::from_file;
    });
    if (from_file && !request.setup->coordinate_file.empty()) {
      auto table = read_motion_table(request.setup->coordinate_file);
      if (!table) return tl::unexpected(table.error());
      command.warn(table->warnings);
      request.coordinate_values = std::move(table->table);
    }
  }
  // Refuses names that a table cannot hold before the work.
  if (!o.output.empty() && !is_motion_text(o.output)) {
    MotionFit empty;
    empty.times = {0};
    empty.q.setZero(1, system->nq);
    if (const auto text = motion_table_text(table_of(*system, empty), o.output); !text)
      return tl::unexpected(text.error());
  }
  ProgressBar progress(command.json);
  progress.begin("inverse kinematics");
  request.progress = [&](double done) { progress.update(done); };
  const auto began = std::chrono::steady_clock::now();
  const auto fit = fit_motion(model->scene, *system, recording->markers, request);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  progress.end(fmt::format("{:.2g} s", seconds));
  if (!fit) return tl::unexpected(fit.error());
  command.warn(fit->warnings);
  command.warn(misfit(fit->rms(), recording->markers));
  if (ending_of(o.output) == ".bvh" && fit->left_out > 0)
    command.warn(fmt::format(
        "frames that were left out between others are interpolated in {}, since BVH has no gaps", o.output));
  if (!o.output.empty()) {
    const auto text =
        is_motion_text(o.output)
            ? motion_text(model->scene, posed_trajectory(*system, {fit->times, fit->q}), o.output)
            : motion_table_text(table_of(*system, *fit), o.output);
    if (!text) return tl::unexpected(text.error());
    if (auto wrote = write_whole(o.output, *text); !wrote) return tl::unexpected(wrote.error());
  }
  if (!o.errors.empty()) {
    const auto text = motion_table_text(error_table_of(*fit), o.errors);
    if (!text) return tl::unexpected(text.error());
    if (auto wrote = write_whole(o.errors, *text); !wrote) return tl::unexpected(wrote.error());
  }
  const json answer = answer_of(o, *fit, seconds);
  if (!command.json) {
    fmt::print("{} frames, {} markers: root mean square error {:.1f} mm", fit->frames.size(),
               fit->markers.size(), 1e3 * fit->rms());
    if (answer.contains("marker_error_max"))
      fmt::print(", largest {:.1f} mm ({} at {:.3f} s)",
                 1e3 * answer["marker_error_max"]["error"].get<double>(),
                 answer["marker_error_max"]["marker"].get<std::string>(),
                 answer["marker_error_max"]["time"].get<double>());
    fmt::print("\n{:.3f} ms and {:.1f} iterations a frame\n", answer["milliseconds_per_frame"].get<double>(),
               answer["iterations_per_frame"].get<double>());
    for (const std::string& file : {o.output, o.errors})
      if (!file.empty()) fmt::print("wrote {}\n", file);
  }
  return answer;
}

}  // namespace

void add_ik(CLI::App& program, Command& command) {
  auto* verb = program.add_subcommand("ik", "Inverse kinematics: the joint angles of a recorded motion");
  auto o = std::make_shared<IkOptions>();
  verb->add_option("model", o->model, "The model: OpenSim, MJCF, URDF or a scene, with markers")->required();
  add_shared(*verb, flags::motion, o->motion, ": .trc, .c3d, or .bvh, whose joint centres are the markers");
  add_output(*verb, o->output, "FILE",
             "Joint angles to write: .mot or .sto of OpenSim, in degrees and m; or a skeleton (.bvh), or the "
             "model's markers (.trc)");
  add_shared(*verb, flags::setup, o->setup, ": which markers and coordinates to follow, and their weights");
  verb->add_option("--errors", o->errors,
                   "Table to write (.sto): the error of every marker in every frame, m")
      ->type_name("FILE");
  add_shared(*verb, flags::from, o->from);
  add_shared(*verb, flags::to, o->to);
  add_shared(*verb, flags::bvh_unit, o->unit);
  add_model_options(*verb, o->how);
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
