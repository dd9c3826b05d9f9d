// borelli scale MODEL --static S.trc -o SCALED: a model made to the size of a person who stands still.
#include <fmt/core.h>

#include "dynamics/formats/model_write.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/motion/static_fit.hpp"
#include "pipeline/recordings/recording.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"
#include "pipeline/verbs/number_check.hpp"
#include "pipeline/verbs/verb.hpp"

namespace borelli {
namespace {

using nlohmann::json;

struct ScaleOptions {
  std::string model, trial, out;
  ModelOptions how;
  StaticFitRequest request;
  bool keep_markers = false;
};

Result<json> work(const ScaleOptions& o, const Command& command) {
  if (!o.out.empty()) {
    if (auto fine = check_model_ending(o.out); !fine) return tl::unexpected(fine.error());
    if (auto fine = check_writable(o.out, {o.model, o.trial}); !fine) return tl::unexpected(fine.error());
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
  json omissions = json::array();
  if (!o.out.empty()) {
    const auto written = write_model(fit->scene, o.out);
    if (!written) return tl::unexpected(written.error());
    if (auto wrote = write_whole(o.out, written->text); !wrote) return tl::unexpected(wrote.error());
    for (const std::string& omission : written->omissions) command.warn("lost or changed: " + omission);
    omissions = written->omissions;
  }
  json factors = json::object();
  for (std::size_t i = 0; i < fit->factors.size(); ++i)
    factors[model->scene.solids[i].name] = fit->factors[i];
  json answer{{"factors", factors},
              {"mass", fit->mass},
              {"marker_error_rms_before", fit->rms_before},
              {"marker_error_rms_after", fit->rms_after}};
  if (!o.out.empty()) answer["out"] = o.out, answer["omissions"] = omissions;
  if (!command.json) {
    for (std::size_t i = 0; i < fit->factors.size(); ++i)
      fmt::print("{:<24} {:.4f}\n", model->scene.solids[i].name, fit->factors[i]);
    fmt::print("mass {:.2f} kg; marker errors {:.1f} mm before, {:.1f} mm after (root mean squares)\n",
               fit->mass, 1e3 * fit->rms_before, 1e3 * fit->rms_after);
    if (!o.out.empty()) fmt::print("wrote {}\n", o.out);
  }
  return answer;
}

}  // namespace

void add_scale(CLI::App& program, Command& command) {
  auto* verb =
      program.add_subcommand("scale", "Make a model the size of a person, from markers of a standing trial");
  auto o = std::make_shared<ScaleOptions>();
  verb->add_option("model", o->model, "The model: OpenSim, MJCF, URDF or a scene, with markers")->required();
  verb->add_option("--static", o->trial, "The standing trial: TRC, C3D or BVH")->required();
  verb->add_option("-o,--out", o->out, "Scaled model to write: a scene (.toml) or .osim, .xml, .mjcf, .urdf");
  verb->add_flag("--per-segment", o->request.per_segment,
                 "A factor for each segment instead of one for the whole body; for a model that can take the "
                 "trial's pose");
  verb->add_option("--mass", o->request.mass,
                   "Mass of the person, kg (default: each segment keeps its density)")
      ->check(positive_number());
  verb->add_flag("--keep-masses", o->request.keep_masses, "Segments keep the masses of the model");
  verb->add_flag("--keep-markers", o->keep_markers,
                 "Leave markers at their scaled places instead of where the trial shows them");
  verb->add_option("--start", o->request.start, "First time of the trial to use, s");
  verb->add_option("--end", o->request.end, "Last time of the trial to use, s");
  add_model_options(*verb, o->how);
  verb->callback([&command, o] { command.work = [o](const Command& c) { return work(*o, c); }; });
}

}  // namespace borelli
