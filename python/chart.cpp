// Charts of error against computing time.
#include <fmt/format.h>

#include <algorithm>

#include "dynamics/methods/integrator.hpp"
#include "pipeline/charts/work_precision_page.hpp"
#include "python/common.hpp"
#include "python/model.hpp"

namespace borelli::python {
namespace {

std::shared_ptr<WorkPrecision> run_chart(const ModelFile& model, const std::vector<std::string>& methods,
                                         const py::object& duration, int outputs, int repeats, int per_decade,
                                         double budget, py::object callback) {
  std::vector<std::string> known = integrator_names();
  known.emplace_back(automatic);
  for (const std::string& method : methods)
    if (std::find(known.begin(), known.end(), method) == known.end())
      refuse("methods", fmt::format("contain '{}'; known: {}", method, fmt::join(known, ", ")));
  WorkPrecisionSettings settings;
  settings.methods = methods;
  settings.outputs = outputs, settings.repeats = repeats, settings.per_decade = per_decade;
  settings.budget = budget;
  Scene scene = model.scene;
  if (!duration.is_none()) scene.simulation.end_time = duration.cast<double>();
  Watch watch(std::move(callback));
  WorkPrecisionObserver observer;
  observer.progress = [&](const std::string& what, double share) { watch.go_on(share, what); };
  return std::make_shared<WorkPrecision>(
      released(watch, [&] { return work_precision(scene, settings, observer); }));
}

py::list points_of(const WorkPrecision& chart) {
  py::list out;
  for (const WorkPrecisionPoint& p : chart.points) {
    const Variant& variant = chart.variants[p.variant];
    py::dict one;
    one["method"] = name_of(variant);
    one[py::str(std::string(setting_name(variant)))] = p.setting;
    one["seconds"] = p.seconds;
    one["evaluations"] = p.evaluations;
    one["error"] = p.finished ? judged_error(chart, p) : std::numeric_limits<double>::quiet_NaN();
    one["trusted"] = p.trusted;
    one["reason"] = p.reason;
    out.append(one);
  }
  return out;
}

py::list recommended(const WorkPrecision& chart) {
  py::list out;
  for (const auto& [digits, point] : recommendations(chart)) {
    py::dict one;
    one["error"] = std::pow(10., -digits);
    one["method"] = name_of(chart.variants[point->variant]);
    one["setting"] = point->setting;
    one["seconds"] = point->seconds;
    out.append(one);
  }
  return out;
}

}  // namespace

void add_charts(py::module_& m) {
  using C = WorkPrecision;
  py::class_<C, std::shared_ptr<C>>(
      m, "Chart", "Error and cost of each method on one scene, over its steps or tolerances.")
      .def_property_readonly(
          "points", &points_of,
          "Per run: method; step (s), tolerance or accuracy; seconds of processor time; "
          "evaluations; error (position over the scene's length, or rad); trusted; reason.")
      .def_property_readonly("recommendations", &recommended,
                             "The fastest trusted run for each power of ten of error.")
      .def_property_readonly(
          "reference", [](const C& c) { return c.reference.words; }, "What runs are compared with.")
      .def(
          "to_pandas",
          [](const C& c) { return py::module_::import("pandas").attr("DataFrame")(points_of(c)); },
          "`points` as a DataFrame.")
      .def(
          "page", [](const C& c) { return work_precision_page(c); }, "The drawings as one HTML page.")
      .def(
          "write",
          [](const C& c, const py::object& folder) {
            value_or_throw(write_work_precision(c, path_of(folder)));
          },
          py::arg("folder"), "Writes chart.html, chart.csv, and the drawings as SVG and PNG.")
      .def("_repr_html_", [](const C& c) { return framed(work_precision_page(c), 700); });
  m.def("chart", &run_chart, py::arg("scene"), py::kw_only(), py::arg("methods") = std::vector<std::string>(),
        py::arg("duration") = py::none(), py::arg("outputs") = 20, py::arg("repeats") = 3,
        py::arg("per_decade") = 1, py::arg("budget") = 0.5, py::arg("callback") = py::none(),
        "Runs a scene with each method over a ladder of steps or tolerances.\n\n"
        "methods: of methods(), or 'auto' (default: all); duration: s; outputs: times at which runs are\n"
        "compared; repeats: runs per point, whose median time counts; per_decade: tolerances; budget: s of\n"
        "processor time after which a ladder ends; callback(share, what): False stops with an Error.");
}

}  // namespace borelli::python
