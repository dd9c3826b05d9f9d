// borelli scale MODEL --static S.trc -o SCALED: a model made to the size of a person who stands still.
#include <fmt/core.h>

#include "dynamics/formats/model_write.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/motion_fit.hpp"
#include "pipeline/motion/static_fit.hpp"
#include "pipeline/recordings/recording.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/shared_flags.hpp"
#include "pipeline/verbs/value_check.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

struct ScaleOptions {
  std::string model, trial, output;
  ModelOptions how;
  StaticFitRequest request;
  bool keep_markers = false;
};

Result<json> work(const ScaleOptions& o, const Command& command) {
  if (!o.output.empty()) {
    if (auto fine = check_model_ending(o.output); !fine) return tl::unexpected(fine.error());
    if (auto fine = check_writable(o.output); !fine) return tl::unexpected(fine.error());
  }
  const auto model = read_model(command, o.model, o.how);
  if (!model) return tl::unexpected(model.error());
  const auto trial = read_recording(o.trial);
  if (!trial) return tl::unexpected(trial.error());
  command.warn(trial->warnings);
  StaticFitRequest request = o.request;
  request.move_markers = !o.keep_markers;
  const auto fit = fit_static(model->scene, trial->markers, request);
  if (!fit) return tl::unexpected(fit.error());
  command.warn(fit->warnings);
  command.warn(misfit(fit->rms_after, mean_frame(trial->markers, request.start, request.end)));
  json omissions = json::array();
  if (!o.output.empty()) {
    const auto written = write_model(fit->scene, o.output);
    if (!written) return tl::unexpected(written.error());
    if (auto wrote = write_whole(o.output, written->text); !wrote) return tl::unexpected(wrote.error());
    for (const std::string& omission : written->omissions)
      command.warn("the written file lacks or changes: " + omission);
    omissions = written->omissions;
  }
  json factors = json::object();
  for (std::size_t i = 0; i < fit->factors.size(); ++i)
    factors[model->scene.solids[i].name] = fit->factors[i];
  json answer{{"factors", factors},
              {"mass", fit->mass},
              {"marker_error_rms_before", fit->rms_before},
              {"marker_error_rms_after", fit->rms_after}};
  if (!o.output.empty()) answer["output"] = o.output, answer["omissions"] = omissions;
  if (!command.json) {
    for (std::size_t i = 0; i < fit->factors.size(); ++i)
      fmt::print("{:<24} {:.4f}\n", model->scene.solids[i].name, fit->factors[i]);
    fmt::print("mass {:.2f} kg; marker errors {:.1f} mm before, {:.1f} mm after (root mean squares)\n",
               fit->mass, 1e3 * fit->rms_before, 1e3 * fit->rms_after);
    if (!o.output.empty()) fmt::print("wrote {}\n", o.output);
  }
  return answer;
}

}  // namespace

void add_scale(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("scale", "Make a model the size of a person, from markers of a standing trial");
  auto o = std::make_shared<ScaleOptions>();
  verb->add_option("model", o->model, "The model: OpenSim, MJCF, URDF or a scene, with markers")->required();
  add_shared(*verb, flags::standing, o->trial)->required();
  add_output(*verb, o->output, "FILE", "Scaled model to write: a scene (.toml) or .osim, .xml, .mjcf, .urdf");
  add_shared(*verb, flags::mass, o->request.mass, " (default: each segment keeps its density)");
  verb->add_flag("--per-segment", o->request.per_segment,
                 "A factor for each segment instead of one for the whole body; for a model that can take the "
                 "trial's pose");
  verb->add_flag("--keep-markers", o->keep_markers,
                 "Leave markers at their scaled places instead of where the trial shows them");
  add_shared(*verb, flags::from, o->request.start);
  add_shared(*verb, flags::to, o->request.end);
  add_model_options(*verb, o->how);
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
