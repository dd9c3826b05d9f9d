#include "pipeline/verbs/motion_info.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "dynamics/formats/scene_file.hpp"
#include "dynamics/system/system.hpp"
#include "pipeline/export/certificate_report.hpp"
#include "pipeline/export/trajectory_file.hpp"
#include "pipeline/verbs/inputs.hpp"
#include "pipeline/verbs/model_options.hpp"

namespace borelli {
namespace {

using nlohmann::json;

std::string kind_of(const Switch& s) {
  std::string kind = std::visit([](const auto& k) { return std::string(k.kind); }, s.kind);
  if (std::holds_alternative<Driven>(s.motion)) kind += ", driven";
  if (std::holds_alternative<Locked>(s.motion)) kind += ", locked";
  if (const auto* coupled = std::get_if<Coupled>(&s.motion)) kind += ", coupled to " + coupled->to;
  return kind;
}

template <class Actions>
json names_and_kinds(const Actions& actions) {
  json out = json::array();
  for (const auto& action : actions)
    out.push_back({{"name", action.name},
                   {"kind", std::visit([](const auto& k) { return std::string(k.kind); }, action.kind)}});
  return out;
}

json coordinates_of(const std::vector<CoordinateInfo>& coordinates) {
  json out = json::array();
  for (const CoordinateInfo& c : coordinates)
    out.push_back(
        {{"name", c.name}, {"kind", c.kind}, {"solid", c.solid}, {"q_size", c.q_size}, {"v_size", c.v_size}});
  return out;
}

// The scene's own name, or "".
std::string scene_name(const std::string& text) {
  const auto scene = parse_scene(text, "scene");
  return scene ? scene->name : "";
}

}  // namespace

Result<json> scene_info(const Command& command, const std::string& path, const ModelOptions& options) {
  const auto model = read_model(command, path, options);
  if (!model) return tl::unexpected(model.error());
  const Scene* const scene = &model->scene;
  const auto system = compile(*scene);
  if (!system) return in_file(path, system.error());
  json solids = json::array();
  double whole = 0;
  for (const Solid& solid : scene->solids) {
    double mass = 0;
    for (const Inertial& i : inertials_of(solid).value_or(std::vector<Inertial>{})) mass += i.mass;
    whole += mass;
    json joint = json::array();
    for (const Switch& s : solid.switches) joint.push_back(kind_of(s));
    solids.push_back({{"name", solid.name}, {"parent", solid.parent}, {"joint", joint}, {"mass", mass}});
  }
  const SimulationSettings& s = scene->simulation;
  return json{
      {"holds", "scene"},
      {"file", path},
      {"name", scene->name},
      {"mass", whole},
      {"degrees_of_freedom", system->nv},
      {"solids", solids},
      {"coordinates", coordinates_of(system->coordinates)},
      {"driven", coordinates_of(system->driven)},
      {"efforts", names_and_kinds(scene->efforts)},
      {"constraints", names_and_kinds(scene->constraints)},
      {"constraint_rows", system->rows},
      {"simulation",
       {{"end_time", s.end_time}, {"method", s.method}, {"step", s.step}, {"tolerance", s.tolerance}}}};
}

std::string scene_info_text(const json& info) {
  std::string out =
      fmt::format("scene '{}': {} solids of {:.6g} kg, {} degrees of freedom, {} constraint rows\n",
                  info["name"].get<std::string>(), info["solids"].size(), info["mass"].get<double>(),
                  info["degrees_of_freedom"].get<int>(), info["constraint_rows"].get<int>());
  for (const json& solid : info["solids"])
    out +=
        fmt::format("  {} on {}: {:.6g} kg, {}\n", solid["name"].get<std::string>(),
                    solid["parent"].get<std::string>(), solid["mass"].get<double>(),
                    solid["joint"].empty()
                        ? "welded"
                        : fmt::format("{}", fmt::join(solid["joint"].get<std::vector<std::string>>(), "; ")));
  for (const char* key : {"efforts", "constraints"})
    for (const json& action : info[key])
      out += fmt::format("  {} '{}': {}\n", std::string(key).substr(0, std::string(key).size() - 1),
                         action["name"].get<std::string>(), action["kind"].get<std::string>());
  const json& s = info["simulation"];
  out += fmt::format("  end time {:g} s, method {}\n", s["end_time"].get<double>(),
                     s["method"].get<std::string>());
  return out;
}

Result<json> trajectory_info(const std::string& path) {
  const auto stored = read_trajectory(path);
  if (!stored) return tl::unexpected(stored.error());
  const Trajectory& t = stored->trajectory;
  json info{{"holds", "trajectory"},
            {"file", path},
            {"scene", scene_name(stored->scene)},
            {"rows", t.times.size()},
            {"solids", t.solids},
            {"coordinates", coordinates_of(t.coordinates)},
            {"multipliers", t.multiplier_names},
            {"certificate", json_of(t.certificate)},
            {"certificate_text", text_of(t.certificate)}};
  if (t.times.empty()) return info;
  info["start"] = {
      {"t", t.times.front()}, {"kinetic", t.kinetic.front()}, {"potential", t.potential.front()}};
  info["end"] = {{"t", t.times.back()}, {"kinetic", t.kinetic.back()}, {"potential", t.potential.back()}};
  return info;
}

std::string trajectory_info_text(const json& info) {
  std::string out = fmt::format("trajectory of scene '{}': {} rows, {} solids, {} coordinates\n",
                                info["scene"].get<std::string>(), info["rows"].get<std::size_t>(),
                                info["solids"].size(), info["coordinates"].size());
  for (const char* when : {"start", "end"})
    if (info.contains(when))
      out += fmt::format("  {} {:.6g} s: kinetic energy {:.6g} J, potential {:.6g} J\n", when,
                         info[when]["t"].get<double>(), info[when]["kinetic"].get<double>(),
                         info[when]["potential"].get<double>());
  return out + info["certificate_text"].get<std::string>();
}

}  // namespace borelli
