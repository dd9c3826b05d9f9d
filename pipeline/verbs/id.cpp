// borelli id MODEL --motion W.mot --forces GRF.xml -o W.sto: joint moments of a recorded motion, by inverse
// dynamics.
#include <fmt/core.h>

#include <filesystem>

#include "error/file_ending.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/effort_report.hpp"
#include "pipeline/motion/foot_contact.hpp"
#include "pipeline/motion/motion_efforts_table.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/recordings/id_setup.hpp"
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

struct IdOptions {
  std::string model, motion, forces, setup, output, powers;
  ModelOptions how;
  std::optional<double> from, to, cutoff;
};

Result<void> use_setup(IdOptions& o, MotionEffortsRequest& request, const Command& command) {
  if (o.setup.empty()) return {};
  const auto setup = read_id_setup(o.setup);
  if (!setup) return tl::unexpected(setup.error());
  for (const auto* lines : {&setup->not_modelled.motion, &setup->not_modelled.other})
    for (const std::string& line : *lines) command.note(fmt::format("{}: not used: {}", o.setup, line));
  request.time_range = setup->time_range;
  request.cutoff = setup->lowpass_cutoff.value_or(0);
  if (o.motion.empty()) o.motion = setup->coordinates_file.string();
  if (o.forces.empty()) o.forces = setup->external_loads_file.string();
  return {};
}

/// The measured forces as loads on bodies: as the set-up of external loads names them, or by which foot
/// stands on which plate.
Result<std::vector<ExternalLoad>> read_loads(const IdOptions& o, const Scene& scene, const System& system,
                                             const RecordedPositions& positions, double cutoff,
                                             const Command& command) {
  if (o.forces.empty()) return std::vector<ExternalLoad>{};
  if (ending_of(o.forces) == ".xml") {
    auto loads = read_external_loads(o.forces);
    if (!loads) return tl::unexpected(loads.error());
    command.warn(loads->warnings);
    return std::move(loads->loads);
  }
  auto recorded = read_forces(o.forces);
  if (!recorded) return tl::unexpected(recorded.error());
  command.warn(recorded->warnings);
  const Eigen::Matrix3d turn = turn_to_scene(scene, recorded->up);
  for (MeasuredForce& force : recorded->forces)
    for (Eigen::Matrix3Xd* values : {&force.force, &force.point, &force.moment}) *values = turn * *values;
  const auto motion = RecordedMotion::of(system, positions, cutoff);
  if (!motion) return tl::unexpected(motion.error());
  auto loads = loads_on_feet(system, *motion, recorded->forces, feet_of(system));
  if (!loads) return tl::unexpected(loads.error());
  command.warn(loads->warnings);
  return std::move(loads->loads);
}

json answer_of(const IdOptions& o, const System& system, const RecordedEfforts& efforts, double cutoff) {
  json coordinates = json::object();
  for (int u = 0; u < system.nv; ++u) {
    double done = 0, taken = 0;
    for (Eigen::Index i = 1; i < efforts.powers.rows(); ++i) {
      const double work = (efforts.powers(i, u) + efforts.powers(i - 1, u)) / 2 *
                          (efforts.times[std::size_t(i)] - efforts.times[std::size_t(i - 1)]);
      (work > 0 ? done : taken) += work;
    }
    coordinates[system.velocity_name(u)] = {{"peak_effort", efforts.efforts.col(u).cwiseAbs().maxCoeff()},
                                            {"peak_power", efforts.powers.col(u).cwiseAbs().maxCoeff()},
                                            {"positive_work", done},
                                            {"negative_work", taken}};
  }
  json answer{{"model", o.model},
              {"rows", efforts.times.size()},
              {"cut_off", cutoff},
              {"root_residuals", residual_report(efforts)},
              {"coordinates", coordinates}};
  if (efforts.peak_force > 0) answer["peak_measured_force"] = efforts.peak_force;
  if (!o.output.empty()) answer["output"] = o.output;
  return answer;
}

void print_answer(const IdOptions& o, const System& system, const RecordedEfforts& efforts,
                  const json& answer) {
  fmt::print("{:<32} {:>12} {:>12} {:>12}\n", "coordinate", "peak effort", "peak power", "work done");
  for (const CoordinateInfo& c : system.coordinates)
    for (int u = c.v_index; u < c.v_index + c.v_size; ++u) {
      const json& one = answer["coordinates"][system.velocity_name(u)];
      fmt::print("{:<32} {:>8.1f} {:<3} {:>10.1f} W {:>10.1f} J\n", system.velocity_name(u),
                 one["peak_effort"].get<double>(), c.angle ? "N m" : "N", one["peak_power"].get<double>(),
                 one["positive_work"].get<double>() + one["negative_work"].get<double>());
    }
  if (!efforts.residuals.empty()) fmt::print("Residuals at the root (a body without errors has none):\n");
  for (const RootResidual& r : efforts.residuals) {
    fmt::print("  {:<30} {:>8.1f} {} rms, {:.1f} {} peak", r.coordinate, r.rms, r.angle ? "N m" : "N", r.peak,
               r.angle ? "N m" : "N");
    if (!r.angle && efforts.peak_force > 0)
      fmt::print(", {:.1f} % of the peak force", 100 * r.peak / efforts.peak_force);
    fmt::print("\n");
  }
  for (const std::string& file : {o.output, o.powers})
    if (!file.empty()) fmt::print("wrote {}\n", file);
}

Result<void> write_table(const MotionTable& table, const std::string& path) {
  const auto text = motion_table_text(table, path);
  return text ? write_whole(path, *text) : tl::unexpected(text.error());
}

Result<json> work(IdOptions o, const Command& command) {
  MotionEffortsRequest request{.cutoff = 6, .time_range = MotionEffortsRequest().time_range, .progress = {}};
  if (auto used = use_setup(o, request, command); !used) return tl::unexpected(used.error());
  if (o.motion.empty()) return bad_use("id", "needs --motion FILE, or a --setup that names one");
  for (const std::string& out : {o.output, o.powers})
    if (!out.empty())
      if (auto fine = check_writable(out, {o.model, o.motion, o.forces, o.setup}); !fine)
        return tl::unexpected(fine.error());
  for (const std::string& out : {o.output, o.powers})
    if (!out.empty())
      if (auto known = expect_ending(out, {".sto", ".mot"}); !known) return tl::unexpected(known.error());
  if (o.cutoff) request.cutoff = *o.cutoff;
  if (o.from) request.time_range.first = *o.from;
  if (o.to) request.time_range.second = *o.to;
  const auto model = read_model(command, o.model, o.how);
  if (!model) return tl::unexpected(model.error());
  const auto system = compile(model->scene);
  if (!system) return in_file(o.model, system.error());
  const auto table = read_motion_table(o.motion);
  if (!table) return tl::unexpected(table.error());
  command.warn(table->warnings);
  const auto positions = positions_in(*system, table->table);
  if (!positions) return bad_use(o.motion, positions.error().what);
  command.warn(positions->warnings);
  const auto loads = read_loads(o, model->scene, *system, positions->positions, request.cutoff, command);
  if (!loads) return tl::unexpected(loads.error());
  ProgressBar progress(command.json);
  progress.begin("inverse dynamics");
  request.progress = [&](double done) { progress.update(done); };
  const auto efforts = efforts_of(*system, positions->positions, *loads, request);
  progress.end("done");
  if (!efforts) return tl::unexpected(efforts.error());
  command.warn(efforts->warnings);
  if (loads->empty() && !efforts->residuals.empty())
    command.warn(
        "no ground force is given, so the force that carries the body appears as a residual at the root");
  if (!o.output.empty())
    if (auto wrote = write_table(effort_table_of(*system, *efforts), o.output); !wrote)
      return tl::unexpected(wrote.error());
  if (!o.powers.empty())
    if (auto wrote = write_table(power_table_of(*system, *efforts), o.powers); !wrote)
      return tl::unexpected(wrote.error());
  const json answer = answer_of(o, *system, *efforts, request.cutoff);
  if (!command.json) print_answer(o, *system, *efforts, answer);
  return answer;
}

}  // namespace

void add_id(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("id", "Inverse dynamics: the joint moments and powers of a recorded motion");
  auto o = std::make_shared<IdOptions>();
  verb->add_option("model", o->model, "The model: OpenSim, MJCF, URDF or a scene")->required();
  add_shared(*verb, flags::motion, o->motion, ": joint angles over time (.mot, .sto), e.g. from borelli ik");
  add_shared(*verb, flags::forces, o->forces);
  add_output(*verb, o->output, "FILE", "Table to write (.sto): the joint moments and forces, N m and N");
  verb->add_option("--powers", o->powers, "Table to write (.sto): the joint powers, W")->type_name("FILE");
  add_shared(*verb, flags::setup, o->setup, ": motion, forces, time range and cut-off");
  add_shared(*verb, flags::cut_off, o->cutoff, " (default: 6, or the set-up's)");
  add_shared(*verb, flags::from, o->from);
  add_shared(*verb, flags::to, o->to);
  add_model_options(*verb, o->how);
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
