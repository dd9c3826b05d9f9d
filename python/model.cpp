// Scenes: reading, writing, looking at them.
#include "python/model.hpp"

#include <fmt/core.h>

#include "dynamics/formats/model_write.hpp"
#include "dynamics/formats/scene_file.hpp"
#include "inertia/inertial.hpp"
#include "python/common.hpp"

namespace borelli::python {
namespace {

using Model = std::shared_ptr<ModelFile>;

Model read_scene_model(const py::object& path, bool floating, double minimum_mass,
                       std::vector<std::string> locked) {
  const std::string file = path_of(path);
  const ModelOptions options{floating, minimum_mass, std::move(locked)};
  auto model = std::make_shared<ModelFile>(released([&] { return read_model(file, options); }));
  std::vector<std::string> warnings;
  for (const std::string& line : model->not_modelled.motion)
    warnings.push_back("not modelled, so the motion differs: " + line);
  warn(warnings);
  return model;
}

Model parse_model(const std::string& text, const std::string& file) {
  auto model = std::make_shared<ModelFile>();
  model->scene = value_or_throw(parse_scene(text, file));
  return model;
}

double mass_of(const Solid& solid) {
  double mass = 0;
  for (const Inertial& inertial : value_or_throw(inertials_of(solid))) mass += inertial.mass;
  return mass;
}

py::list solids_of(const ModelFile& model) {
  py::list out;
  for (const Solid& solid : model.scene.solids) {
    py::dict one;
    one["name"] = solid.name;
    one["parent"] = solid.parent;
    one["mass"] = mass_of(solid);
    out.append(one);
  }
  return out;
}

std::string model_html(const ModelFile& model) {
  std::vector<std::vector<std::string>> rows{{"solid", "parent", "mass, kg"}};
  for (const Solid& solid : model.scene.solids)
    rows.push_back({solid.name, solid.parent, fmt::format("{:.4g}", mass_of(solid))});
  return html_table(rows, model.scene.name);
}

template <auto write>
std::string foreign_text(const ModelFile& model) {
  WrittenModel written = value_or_throw(write(model.scene, {}));
  for (std::string& omission : written.omissions) omission.insert(0, "the written file lacks or changes: ");
  warn(written.omissions);
  return std::move(written.text);
}

}  // namespace

std::shared_ptr<const CompiledScene> compiled(std::shared_ptr<const ModelFile> model) {
  auto out = std::make_shared<CompiledScene>();
  out->system = released([&] { return compile(model->scene); });
  out->model = std::move(model);
  return out;
}

void add_scene(py::module_& m) {
  py::class_<ModelFile, Model>(m, "Scene", "A scene: a tree of solids with joints, forces and constraints.")
      .def_static("from_toml", &parse_model, py::arg("text"), py::arg("file") = "scene",
                  "The scene of a TOML text (docs/scenes.md). `file` names it in errors.")
      .def_property_readonly(
          "name", [](const ModelFile& s) { return s.scene.name; }, "Its name.")
      .def_property_readonly(
          "description", [](const ModelFile& s) { return s.scene.description; }, "Its description, in words.")
      .def_property(
          "gravity", [](const ModelFile& s) { return copy(s.scene.gravity); },
          [](ModelFile& s, const Numbers& g) { s.scene.gravity = vector_of(g, 3, "gravity"); },
          "Gravity, m/s^2, world axes, (3,). A copy; assign to change it.")
      .def_property_readonly("solids", &solids_of,
                             "The solids in the file's order: name, parent ('world': none), mass (kg).")
      .def_property(
          "duration", [](const ModelFile& s) { return s.scene.simulation.end_time; },
          [](ModelFile& s, double seconds) { s.scene.simulation.end_time = seconds; },
          "The length of its motion, s.")
      .def_property_readonly(
          "not_modelled",
          [](const ModelFile& s) {
            std::vector<std::string> all = s.not_modelled.motion;
            all.insert(all.end(), s.not_modelled.other.begin(), s.not_modelled.other.end());
            return all;
          },
          "What the file holds and the scene does not, one sentence each. What changes the motion was a "
          "warning.")
      .def(
          "to_toml", [](const ModelFile& s) { return value_or_throw(write_scene(s.scene)); },
          "The text of the scene; from_toml restores every number.")
      .def("to_mjcf", &foreign_text<&write_mjcf>,
           "The scene as MJCF (MuJoCo). What the format lacks is a DoubtWarning.")
      .def("to_urdf", &foreign_text<&write_urdf>,
           "The scene as URDF. What the format lacks is a DoubtWarning.")
      .def("to_osim", &foreign_text<&write_osim>,
           "The scene as a model of OpenSim 4. What the format lacks is a DoubtWarning.")
      .def("__repr__",
           [](const ModelFile& s) {
             return fmt::format("<borelli.Scene '{}', {} solids>", s.scene.name, s.scene.solids.size());
           })
      .def("_repr_html_", &model_html);
  m.def("read_model", &read_scene_model, py::arg("path"), py::kw_only(), py::arg("floating") = false,
        py::arg("minimum_mass") = 0.0, py::arg("locked") = std::vector<std::string>(),
        "Reads a scene: this program's TOML, MJCF, URDF or a model of OpenSim.\n\n"
        "floating: the root link of a URDF moves freely\n"
        "minimum_mass: moving bodies of URDF and OpenSim lighter than this (kg) become balls of it\n"
        "locked: names of coordinates or joints that stay at their initial values\n\n"
        "Raises Error that names file and line. Content that changes the motion and is not modelled is a "
        "DoubtWarning.");
}

}  // namespace borelli::python
