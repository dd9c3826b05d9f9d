#include "pipeline/stages/run_body.hpp"

#include <fmt/core.h>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "dynamics/methods/integrator.hpp"
#include "dynamics/run/simulate.hpp"
#include "error/json_text.hpp"
#include "pipeline/charts/economy_page.hpp"
#include "pipeline/export/body_model.hpp"
#include "pipeline/export/certificate_report.hpp"
#include "pipeline/export/deface.hpp"
#include "pipeline/export/glb.hpp"
#include "pipeline/export/mesh.hpp"
#include "pipeline/export/mesh_file.hpp"
#include "pipeline/export/render.hpp"
#include "pipeline/export/skin.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/files/warnings_json.hpp"
#include "pipeline/files/whole_file.hpp"
#include "pipeline/report/range_warning.hpp"
#include "pipeline/report/report.hpp"
#include "pipeline/stages/run_video.hpp"
#include "process/input_file.hpp"

namespace borelli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Warnings = std::vector<std::string>;

Result<void> take_face(const RunSettings& settings, std::vector<Mesh>& meshes, const LabelMap& labels,
                       const Landmarks& landmarks, Warnings& warnings) {
  const auto cut = face_cut(labels, landmarks);
  if (cut) return deface(meshes, labels, *cut, {1e-3 * settings.mesh_tolerance_mm, settings.threads, {}});
  warnings.emplace_back(no_face_found);
  return {};
}

Result<json> read_object(const fs::path& path) {
  const auto bytes = read_input_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto object = parse_json(*bytes, path.string());
  if (!object || !object->is_object())
    return failure(path.string(), "is damaged; remove it, and the next run writes it again");
  return object;
}

// The report's inputs from the scan and its parts.
Result<ReportInputs> page_of_scan(RunData& data) {
  const auto scan = data.scan();
  if (!scan) return tl::unexpected(scan.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const auto labels = data.labels();
  if (!labels) return tl::unexpected(labels.error());
  auto account = read_object(data.file("segmentation/segmentation.json"));
  if (!account) return tl::unexpected(account.error());
  ReportInputs page;
  page.grey = &(*scan)->volume;
  page.labels = *labels;
  page.landmarks = &(*segmentation)->landmarks;
  page.segmentation = std::move(*account);
  page.deface = data.settings.deface;
  return page;
}

void set_integration(const RunSettings& settings, SimulationSettings& simulation) {
  simulation.equations = settings.equations == "lagrange" ? Equations::lagrange : Equations::recursive;
  if (settings.method.empty()) {
    simulation.accuracy = settings.accuracy;
    return;
  }
  simulation.method = settings.method;
  simulation.tolerance = settings.integrator_tolerance;
  simulation.step = settings.step.value_or(simulation.step);
}

bool steps_are_fixed(const SimulationSettings& simulation) {
  return simulation.accuracy == 0 && !method_is_adaptive(simulation.method);
}

}  // namespace

Result<json> build_scene(RunData& data) {
  const auto table = data.table();
  if (!table) return tl::unexpected(table.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  std::vector<Warning> warnings;
  const PartInertials present = movable_parts(**table, warnings);
  if (present.empty())
    if (const auto scan = data.scan(); scan && (*scan)->volume.quantity == Quantity::mr)
      return failure(data.settings.volume,
                     "is an MR volume, in which parts cannot be found without help; labels.nii.gz and "
                     "table.csv hold its tissues; for a moving body give a label map (--labels with "
                     "--label-mapping) or the joint centres (--landmarks)");
  SkeletonOptions options{data.settings.subject, data.settings.leap, stated_absent(**table)};
  if (!data.settings.captured.motion.empty()) options.leap.reset();
  auto skeleton = build_skeleton(present, (*segmentation)->landmarks, options);
  if (!skeleton) return tl::unexpected(skeleton.error());
  set_integration(data.settings, skeleton->scene.simulation);
  const auto text = write_scene(skeleton->scene);
  if (!text) return tl::unexpected(text.error());
  if (auto written = write_whole(data.file("model/scene.toml"), *text); !written)
    return tl::unexpected(written.error());
  warnings.insert(warnings.end(), skeleton->warnings.begin(), skeleton->warnings.end());
  data.keep(std::move(skeleton->scene));
  return warnings_entry(warnings);
}

Result<json> find_smallest(RunData& data, const StageProgress& progress) {
  const auto scene = data.scene();
  if (!scene) return tl::unexpected(scene.error());
  EconomySettings asked{.quantities = data.settings.motion_quantities,
                        .tolerance = data.settings.model_tolerance};
  const auto economy =
      scene_economy(**scene, asked, [&](const std::string&, double share) { progress(share); });
  if (!economy) return tl::unexpected(economy.error());
  Scene smallest = economy->smallest;
  smallest.description += fmt::format("\nReduced from the whole model: {}.", in_words(*economy));
  const auto text = write_scene(smallest);
  if (!text) return tl::unexpected(text.error());
  if (auto written = write_whole(data.file("model/smallest.toml"), *text); !written)
    return tl::unexpected(written.error());
  if (auto written =
          write_whole(data.file("model/economy.html"), economy_page(*economy, data.reader_warnings()));
      !written)
    return tl::unexpected(written.error());
  const EconomyModel &whole = economy->models.front(), &least = economy->models.back();
  json locked = json::array();
  for (const EconomyModel& model : economy->models)
    if (!model.change.empty()) locked.push_back(model.change);
  data.keep_smallest(std::move(smallest));
  return json{
      {"economy",
       {{"tolerance", economy->tolerance},
        {"quantities", economy->quantities},
        {"error", least.error},
        {"coordinates", least.coordinates},
        {"bodies", least.bodies},
        {"evaluations", least.evaluations},
        {"whole",
         {{"coordinates", whole.coordinates}, {"bodies", whole.bodies}, {"evaluations", whole.evaluations}}},
        {"locked", locked},
        {"search", {{"runs", economy->runs}, {"evaluations", economy->evaluations}}},
        {"in_words", in_words(*economy)}}}};
}

Result<json> simulate_scene(RunData& data, const StageProgress& progress) {
  std::error_code ignored;
  if (data.settings.model_tolerance == 0)  // left by an earlier run with such a tolerance
    for (const char* name : {"model/smallest.toml", "model/economy.html"})
      fs::remove(data.file(name), ignored);
  const auto scene = data.moving();
  if (!scene) return tl::unexpected(scene.error());
  const auto system = compile(**scene);
  if (!system) return tl::unexpected(system.error());
  const double end = (*scene)->simulation.end_time;
  bool goes_on = true;
  auto trajectory = simulate(*system, system->initial, system->settings,
                             {[&](double t) { return goes_on = progress(t / end); }});
  if (!trajectory) return tl::unexpected(trajectory.error());
  if (!goes_on) return failure((*scene)->name, "the motion was stopped");
  const Certificate& certificate = trajectory->certificate;
  if (!certificate.trusted && !data.settings.untrusted_is_fine)
    return failure(
        (*scene)->name,
        fmt::format(
            "the certificate does not trust the motion: {} ({}give --allow-untrusted to continue with it)",
            certificate.reason, steps_are_fixed((*scene)->simulation) ? "give a shorter --step; " : ""));
  const auto text = write_scene(**scene);
  if (!text) return tl::unexpected(text.error());
  for (const char* name : {"motion/trajectory.h5", "motion/trajectory.csv"})
    if (auto written =
            write_whole(data.file(name),
                        [&](const fs::path& beside) { return write_trajectory(*trajectory, *text, beside); });
        !written)
      return tl::unexpected(written.error());
  Warnings warnings = warnings_of(certificate, *system);
  if (!certificate.trusted)
    warnings.push_back("the certificate does not trust the motion: " + certificate.reason);
  json answer{{"warnings", warnings}, {"certificate", json_of(certificate)}};
  data.keep(std::move(*trajectory));
  return answer;
}

Result<json> make_meshes(RunData& data, const StageProgress& progress) {
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const auto labels = data.labels();
  if (!labels) return tl::unexpected(labels.error());
  auto meshes =
      part_meshes(**labels, {1e-3 * data.settings.mesh_tolerance_mm, data.settings.threads, progress});
  if (!meshes) return tl::unexpected(meshes.error());
  Warnings warnings;
  if (data.settings.deface) {
    if (auto done =
            take_face(data.settings, *meshes, (*segmentation)->labels, (*segmentation)->landmarks, warnings);
        !done)
      return tl::unexpected(done.error());
  }
  std::error_code ignored;
  fs::remove_all(data.file("mesh"), ignored);  // left by an earlier run that found other parts
  const auto written = write_meshes(data.file("mesh"), *meshes);
  if (!written) return tl::unexpected(written.error());
  json counts = json::object();
  for (const Mesh& mesh : *meshes) counts[mesh.name] = mesh.triangles.size();
  json files = json::array();
  for (const fs::path& path : *written)
    files.push_back(path.lexically_relative(data.settings.folder).string());
  data.keep(std::move(*meshes));
  return json{{"triangles", counts}, {"files", files}, {"warnings", warnings}};
}

// A scene edited by hand may contain something that a format cannot hold. That model is then left out, with a
// warning.
Result<json> write_models(RunData& data) {
  const auto scene = data.scene();
  if (!scene) return tl::unexpected(scene.error());
  const auto table = data.table();
  if (!table) return tl::unexpected(table.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  const Landmarks& landmarks = (*segmentation)->landmarks;
  std::vector<Warning> said_by_the_scene;
  const PartInertials present = movable_parts(**table, said_by_the_scene);
  std::vector<fs::path> meshes;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(data.file("mesh"), ignored))
    if (entry.path().extension() == ".stl") meshes.push_back(fs::path("../mesh") / entry.path().filename());
  std::ranges::sort(meshes);
  const Scene marked = with_landmark_markers(**scene, present, landmarks);
  const ModelExtras extras = body_extras(**table, present, landmarks, meshes);
  json answer{{"files", json::array()}, {"omissions", json::object()}, {"warnings", json::array()}};
  for (const char* name : {"model/body.osim", "model/body.xml"}) {
    const auto model = write_model(marked, name, extras);
    if (!model) {
      fs::remove(data.file(name), ignored);  // of an earlier run
      answer["warnings"].push_back(fmt::format("{} was not written: {}", name, model.error().message()));
      continue;
    }
    if (auto written = write_whole(data.file(name), model->text); !written)
      return tl::unexpected(written.error());
    answer["files"].push_back(name);
    answer["omissions"][name] = model->omissions;
  }
  return answer;
}

Result<json> make_glb(RunData& data) {
  const auto meshes = data.meshes();
  if (!meshes) return tl::unexpected(meshes.error());
  const auto X_WS = data.poses();
  if (!X_WS) return tl::unexpected(X_WS.error());
  const auto trajectory = data.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto bytes = glb(**meshes, **X_WS, **trajectory, {data.settings.subject});
  if (!bytes) return tl::unexpected(bytes.error());
  if (auto written = write_whole(data.file("body.glb"), *bytes); !written)
    return tl::unexpected(written.error());
  return json::object();
}

Result<json> make_skin(RunData& data) {
  const auto trajectory = data.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  const auto skin = data.skin();
  if (!skin) return tl::unexpected(skin.error());
  const auto bytes = glb(**skin, **trajectory, {data.settings.subject});
  if (!bytes) return tl::unexpected(bytes.error());
  if (auto written = write_whole(data.file("skin.glb"), *bytes); !written)
    return tl::unexpected(written.error());
  return json{{"triangles", (*skin)->mesh.triangles.size()}, {"bones", (*skin)->bones.size()}};
}

Result<json> draw_picture(RunData& data) {
  if (const auto fine = can_draw(); !fine) {
    std::error_code ignored;
    fs::remove(data.file("body.png"), ignored);  // from an earlier run with other parts
    return json{{"warnings", {"no picture (body.png) was drawn: " + fine.error().message()}},
                {"files", json::array()},
                {"key", ""}};
  }
  const auto meshes = data.meshes();
  if (!meshes) return tl::unexpected(meshes.error());
  const auto segmentation = data.segmentation();
  if (!segmentation) return tl::unexpected(segmentation.error());
  PictureOptions options;
  std::vector<std::string> shown;
  for (const Mesh& mesh : **meshes) shown.push_back(mesh.name);
  for (const Part& part : segment_tree(shown))
    if (const auto joint = (*segmentation)->landmarks.find(part.joint);
        joint != (*segmentation)->landmarks.end())
      options.joints.push_back(1e-3 * joint->second.point);
  auto drawn = write_whole(data.file("body.png"), [&](const fs::path& beside) {
    return draw_body(beside.string(), **meshes, options);
  });
  if (!drawn) return tl::unexpected(drawn.error());
  return json::object();
}

Result<json> pack_scan(RunData& data) {
  const auto page = page_of_scan(data);
  if (!page) return tl::unexpected(page.error());
  auto views = scan_views(*page);
  if (!views) return tl::unexpected(views.error());
  data.keep(std::move(*views));
  return json::object();
}

Result<json> write_page(RunData& data, const json& record) {
  auto page = page_of_scan(data);
  if (!page) return tl::unexpected(page.error());
  const auto trajectory = data.trajectory();
  if (!trajectory) return tl::unexpected(trajectory.error());
  auto table = read_object(data.file("inertia/table.json"));
  if (!table) return tl::unexpected(table.error());
  const auto body = read_input_file(data.file("body.glb"), any_size);
  if (!body) return tl::unexpected(body.error());
  if (!data.settings.captured.motion.empty()) {
    auto efforts = read_object(data.file("motion/efforts.json"));
    if (!efforts) return tl::unexpected(efforts.error());
    page->efforts = std::move(*efforts);
  }
  page->subject = data.settings.subject;
  page->table = std::move(*table);
  page->trajectory = *trajectory;
  page->glb = *body;
  page->run = record;
  for (const json& stage : record["stages"])
    if (stage.contains("economy")) page->run["smallest model"] = stage["economy"]["in_words"];
  page->files = report_files(data.settings.folder);
  page->views = data.views();
  auto written = write_whole(data.file("report.html"),
                             [&](const fs::path& beside) { return write_report(*page, beside); });
  if (!written) return tl::unexpected(written.error());
  return json::object();
}

}  // namespace borelli
