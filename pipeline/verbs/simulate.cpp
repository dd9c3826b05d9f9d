// borelli simulate SCENE: integrates a scene, prints its certificate, writes its trajectory.
#include "dynamics/run/simulate.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <optional>

#include "dynamics/equations/reaction.hpp"
#include "dynamics/formats/model_file.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "error/file_ending.hpp"
#include "error/json_text.hpp"
#include "pipeline/export/certificate_report.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/export/unfinished_rows.hpp"
#include "pipeline/files/file_order.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/motion_text.hpp"
#include "pipeline/report/scene_meshes.hpp"
#include "pipeline/verbs/checkpoint.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/progress.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"
#include "pipeline/verbs/video_options.hpp"

namespace borelli {
namespace {

// Command-line options; missing ones come from the scene.
struct SimulateOptions {
  std::string scene, output, checkpoint;
  std::optional<double> checkpoint_every;
  VideoAsked video;
  ModelOptions model;
  std::optional<std::string> method, equations, constraints, impacts;
  std::optional<double> step, tolerance, accuracy, end, output_interval;
  bool allow_untrusted = false, reactions = false, verify = false;
};

SimulationSettings settings_of(SimulationSettings s, const SimulateOptions& o) {
  s.method = o.method.value_or(s.method);
  if (o.equations) s.equations = *o.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  if (o.constraints)
    s.constraints =
        *o.constraints == "baumgarte" ? ConstraintTreatment::baumgarte : ConstraintTreatment::projection;
  s.step = o.step.value_or(s.step);
  s.tolerance = o.tolerance.value_or(s.tolerance);
  s.accuracy = o.accuracy.value_or(o.method || o.tolerance ? 0 : s.accuracy);
  s.verify = s.verify || o.verify;
  s.end_time = o.end.value_or(s.end_time);
  s.output_interval = o.output_interval.value_or(s.output_interval);
  if (o.impacts) s.impacts = *o.impacts == "simultaneous" ? ImpactLaw::simultaneous : ImpactLaw::sequential;
  return s;
}

// Refuses an option that would have no effect, since the user expects one.
Result<void> check_effect(const SimulateOptions& o, const SimulationSettings& settings) {
  if (o.tolerance && !method_is_adaptive(settings.method))
    return bad_use("--tolerance", "has no effect with " + settings.method +
                                      ", whose steps have a fixed length; give --step");
  if (o.step && settings.accuracy > 0)
    return bad_use("--step", fmt::format("has no effect with an accuracy of {:g}, which chooses the steps; "
                                         "give --method, or leave out --step",
                                         settings.accuracy));
  if (o.verify && settings.accuracy == 0) return bad_use("--verify", "has no effect without --accuracy");
  if (o.checkpoint_every && o.checkpoint.empty())
    return bad_use("--checkpoint-every", "has no effect without --checkpoint");
  if (o.reactions && o.output.empty())
    return bad_use("--reactions", "has no effect without --output, which holds the reactions");
  return {};
}

// Whether the output shows the motion alone, in equal steps, instead of storing the whole run.
bool shows_motion(const std::string& output) {
  const std::string ending = ending_of(output);
  return ending == ".glb" || ending == ".html" || is_motion_text(output);
}

Result<std::string> shown_motion(const Scene& scene, const Trajectory& trajectory, const std::string& output,
                                 const std::vector<std::string>& warnings) {
  if (ending_of(output) == ".glb") return scene_glb(scene, trajectory);
  if (ending_of(output) == ".html") return scene_page(scene, trajectory, warnings);
  return motion_text(scene, trajectory, output);
}

nlohmann::json answer_of(const SimulateOptions& o, const ModelFile& model, const Trajectory& t,
                         bool written) {
  const FileOrder order = file_order(model.scene, t.coordinates);
  nlohmann::json coordinates = nlohmann::json::array();
  for (const CoordinateInfo& c : order.coordinates)
    coordinates.push_back(
        {{"name", c.name}, {"kind", c.kind}, {"q_index", c.q_index}, {"v_index", c.v_index}});
  const auto last = [](const Rows& rows, const std::vector<Eigen::Index>& entries) {
    return rows.rows() > 0 ? in_file_order(rows.bottomRows(1).transpose(), entries) : std::vector<double>();
  };
  nlohmann::json answer{
      {"scene", o.scene},
      {"output", written ? nlohmann::json(o.output) : nlohmann::json()},
      {"rows", t.times.size()},
      {"coordinates", coordinates},
      {"end",
       {{"t", t.times.empty() ? 0 : t.times.back()}, {"q", last(t.q, order.q)}, {"v", last(t.v, order.v)}}},
      {"certificate", json_of(t.certificate)}};
  return answer;
}

Result<Trajectory> run(const SimulateOptions& o, const Command& command, const ModelFile& model,
                       std::optional<CheckpointFile>& checkpoint, std::optional<UnfinishedRows>& unfinished) {
  const Scene& scene = model.scene;
  const auto system = compile(scene);
  if (!system) return in_file(o.scene, system.error());
  SimulationSettings settings = settings_of(scene.simulation, o);
  const bool interval_is_given = settings.output_interval > 0;
  // viewers interpolate linearly between rows, and steps may be long
  if ((shows_motion(o.output) || !o.video.file.empty()) && settings.output_interval == 0)
    settings.output_interval = std::min(1. / 60, settings.end_time / 300);
  if (is_motion_text(o.output)) {  // its frames are equally far apart
    const double span = settings.end_time - system->initial.t;
    const double equal = span / std::max(1., std::ceil(span / settings.output_interval - 1e-6));
    if (interval_is_given && std::abs(equal - settings.output_interval) > 1e-9 * settings.output_interval)
      command.note(fmt::format("frames are {:.6g} s apart, so that the last one is at the end", equal));
    if (equal > 0) settings.output_interval = equal;
  }
  if (auto fine = check_effect(o, settings); !fine) return tl::unexpected(fine.error());
  ProgressBar bar(command.json);
  bar.begin("simulate");
  Observer observer;
  observer.progress = [&](double t) {
    bar.update(t / settings.end_time);
    return true;
  };
  const bool writes_rows = !o.output.empty() && !shows_motion(o.output);
  if (!o.checkpoint.empty() || writes_rows) {
    Scene settled = scene;
    settled.simulation = settings;
    const auto text = write_scene(settled);
    if (!text) return tl::unexpected(text.error());
    if (!o.checkpoint.empty()) {
      checkpoint.emplace(o.checkpoint, o.checkpoint_every.value_or(60));
      if (auto fine = checkpoint->watch(*text, observer); !fine) return tl::unexpected(fine.error());
    }
    if (writes_rows) unfinished.emplace(o.output, *text).watch(observer);
  }
  auto trajectory = simulate(*system, system->initial, settings, observer);
  if (checkpoint) checkpoint->run_is_over();
  if (!trajectory && trajectory.error().where == "checkpoint")
    return tl::unexpected(Error{o.checkpoint, trajectory.error().what, trajectory.error().kind});
  if (!trajectory) return in_file(o.scene, trajectory.error());
  if (checkpoint) {
    if (!checkpoint->written()) return tl::unexpected(checkpoint->written().error());
    if (checkpoint->stopped())
      return failure(o.scene,
                     fmt::format("stopped at t = {:.6g} s of {:.6g} s; the same command continues from {}",
                                 trajectory->times.back(), settings.end_time, o.checkpoint));
  }
  judge_passing(model.without_contact, *trajectory);
  if (o.reactions)
    if (const auto done = add_reactions(scene, *trajectory); !done) return in_file(o.scene, done.error());
  bar.end(settings.accuracy > 0
              ? fmt::format("simulated {:g} s with accuracy {:g}", settings.end_time, settings.accuracy)
              : fmt::format("{}, simulated {:g} s", settings.method, settings.end_time));
  return trajectory;
}

Result<void> film(const SimulateOptions& o, const Command& command, const Scene& scene,
                  const Trajectory& trajectory) {
  ProgressBar bar(command.json);
  bar.begin("video");
  const auto frames = write_scene_video(o.video, scene, trajectory, [&](double share) {
    bar.update(share);
    return true;
  });
  if (!frames) return tl::unexpected(frames.error());
  bar.end(fmt::format("{}: {} frames", o.video.file, *frames));
  return {};
}

Result<nlohmann::json> work(const SimulateOptions& o, const Command& command) {
  // check the output's name before the work
  const std::string ending = ending_of(o.output);
  const bool shows = shows_motion(o.output);
  if (!o.output.empty()) {
    const auto known = expect_ending(o.output, {".h5", ".hdf5", ".csv", ".glb", ".html", ".bvh", ".trc"});
    if (!known) return tl::unexpected(known.error());
    if (auto fine = check_writable(o.output); !fine) return tl::unexpected(fine.error());
  }
  if (auto fine = check_effect(o.video); !fine) return tl::unexpected(fine.error());
  if (!o.video.file.empty()) {
    if (const auto fine = video_options(o.video); !fine) return tl::unexpected(fine.error());
    if (auto fine = check_writable(o.video.file); !fine) return tl::unexpected(fine.error());
  }
  const auto model = ending == ".html" ? read_model_for_pages(command, o.scene, o.model)
                                       : read_model(command, o.scene, o.model);
  if (!model) return tl::unexpected(model.error());
  const Scene& scene = model->scene;
  std::optional<CheckpointFile> checkpoint;
  std::optional<UnfinishedRows> unfinished;
  auto trajectory = run(o, command, *model, checkpoint, unfinished);
  if (!trajectory) return tl::unexpected(trajectory.error());

  const Certificate& certificate = trajectory->certificate;
  if (!command.json) fmt::print("{}", text_of(certificate));
  if (!certificate.trusted && !o.allow_untrusted) {
    if (command.json)
      fmt::print("{}\n", json_text(command.complete(answer_of(o, *model, *trajectory, false)), 2));
    return failure(
        o.scene,
        fmt::format("the certificate does not trust the run: {}; {}give --allow-untrusted to accept it",
                    certificate.reason,
                    o.output.empty() && o.video.file.empty() ? "" : "nothing was written; "));
  }
  const nlohmann::json answer = answer_of(o, *model, *trajectory, !o.output.empty());
  const std::vector<std::string> warnings = command.warnings_in_files();
  if (ending != ".html")  // pages list warnings themselves; other files store them in the certificate's notes
    for (const std::string& warning : warnings)
      trajectory->certificate.notes.push_back("warning: " + warning);
  if (!o.output.empty()) {
    auto settled = scene;
    settled.simulation = settings_of(scene.simulation, o);
    const auto text = write_scene(settled);
    if (!text) return tl::unexpected(text.error());
    const auto seen = shows ? shown_motion(scene, *trajectory, o.output, warnings) : std::string();
    if (!seen) return tl::unexpected(seen.error());
    const auto done =
        shows ? write_whole(o.output, *seen) : write_whole(o.output, [&](const std::filesystem::path& path) {
          return write_trajectory(*trajectory, *text, path);
        });
    if (!done) return tl::unexpected(done.error());
    if (!command.json) fmt::print("{}: {} rows\n", o.output, trajectory->times.size());
  }
  if (!o.video.file.empty())
    if (const auto done = film(o, command, scene, *trajectory); !done) return tl::unexpected(done.error());
  if (checkpoint) checkpoint->remove();
  return answer;
}

}  // namespace

void add_simulate(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("simulate", "Integrate a scene, print its certificate and write its trajectory");
  auto o = std::make_shared<SimulateOptions>();
  verb->add_option("scene", o->scene, "Scene file: TOML, MJCF, URDF or OpenSim")->required();
  add_output(*verb, o->output, "FILE",
             "Trajectory to write: .h5 (complete), .csv, .glb (moving solids), .html (a page), .bvh (a "
             "skeleton) or .trc (the scene's markers)");
  add_shared(*verb, flags::end, o->end);
  auto* accuracy = add_shared(*verb, flags::accuracy, o->accuracy);
  add_shared(*verb, flags::allow_untrusted, o->allow_untrusted);
  add_shared(*verb, flags::method, o->method, " (default: the scene's)")->excludes(accuracy);
  add_shared(*verb, flags::equations, o->equations, " (default: the scene's)");
  add_shared(*verb, flags::step, o->step);
  add_shared(*verb, flags::tolerance, o->tolerance)->excludes(accuracy);
  verb->add_flag(
      "--verify", o->verify,
      "With --accuracy: run again with a tenth of the tolerance and report the difference as error");
  add_shared(*verb, flags::constraints, o->constraints, " (default: the scene's)");
  verb->add_option("--impacts", o->impacts,
                   "Treatment of contacts that collide at the same moment: sequential (pair by pair) or "
                   "simultaneous (all at once) (default: the scene's)")
      ->type_name("NAME")
      ->check(one_of({"sequential", "simultaneous"}));
  verb->add_option("--output-interval", o->output_interval,
                   "Time between output rows, s; 0 writes every accepted step")
      ->check(number_not_negative());
  verb->add_flag("--reactions", o->reactions, "Also write the force and moment through each joint");
  verb->add_option("--checkpoint", o->checkpoint,
                   "File that stores the run at intervals and on ^C; the same command continues from it and "
                   "removes it once the result is written")
      ->type_name("FILE");
  verb->add_option("--checkpoint-every", o->checkpoint_every,
                   "Time between writes of the checkpoint, s (default: 60)")
      ->check(number_not_negative());
  add_video_options(*verb, o->video,
                    "rows are then at most 1/60 s apart unless --output-interval says otherwise");
  group_options(
      *verb, "Method",
      {"--method", "--equations", "--step", "--tolerance", "--verify", "--constraints", "--impacts"});
  group_options(*verb, "Results", {"--output-interval", "--reactions", "--checkpoint", "--checkpoint-every"});
  add_model_options(*verb, o->model);
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
