// From a volume to labelled parts and landmarks.
#include "python/segmentation.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "pipeline/body/belonging.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "pipeline/body/segmentation_files.hpp"
#include "python/volume.hpp"
#include "segmentation/files/class_labels.hpp"
#include "segmentation/labelling/body_doubts.hpp"
#include "segmentation/labelling/verdict.hpp"

namespace borelli::python {
namespace {

Result<Segmentation> part_volume(const GreyVolume& volume, const SegmentOptions& options) {
  if (volume.quantity != Quantity::mr) return segment(volume, options);
  const auto reading = read_mr(volume, options.classes, options.threads);
  if (!reading) return tl::unexpected(reading.error());
  return segment_mr(*reading, options);
}

std::shared_ptr<PartedScan> run_segmentation(const NamedScan& scan, double step,
                                             const std::string& convention_name, const py::object& landmarks,
                                             const std::string& absent, const py::object& classes,
                                             const std::string& names, const std::string& mapping,
                                             int threads, py::object callback) {
  SegmentOptions options{step, threads};
  options.convention = value_or_throw(convention(convention_name));
  options.absent = value_or_throw(parse_absent(absent));
  options.given = landmarks_of(landmarks);
  Watch watch(std::move(callback));
  options.progress = [&](double share, std::string_view next) { watch.go_on(share, next); };
  const GreyVolume& volume = scan.scan.volume;
  std::optional<ClassLabels> others;
  if (classes.is_none() && !(mapping.empty() && names.empty()))
    refuse(mapping.empty() ? "class_names" : "mapping", "has no effect without classes");
  if (!classes.is_none()) {
    if (mapping.empty())
      refuse(
          "mapping",
          "is missing; name a ready mapping (totalsegmentator ...) or a file that says what each class is");
    const std::string file = path_of(classes);
    others = released([&] { return read_classes(file, names, mapping, &volume); });
    warn(others->warnings);
    options.classes = &*others;
  }
  auto out = std::make_shared<PartedScan>();
  out->found = released(watch, [&] {
    auto found = part_volume(volume, options);
    if (found && options.classes)
      add_warnings(found->warnings, WarningKind::labels, Severity::doubt,
                   {doubt_of_classes(volume, *options.classes, threads)});
    return found;
  });
  add_reader_warnings(scan.scan.warnings, volume.grid, out->found);
  out->input = scan.name, out->reading = scan.scan.reading;
  warn(in_sentences(out->found.warnings));
  return out;
}

py::list findings_of(const PartedScan& s) {
  py::list out;
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const PartFinding& part = s.found.part[n];
    py::dict one;
    one["part"] = std::string(parts[n].name);
    one["label"] = n;
    one["coverage"] = std::string(name_of(part.coverage));
    one["volume_m3"] = part.volume * 1e-9;
    one["confidence"] = part.confidence;
    one["note"] = part.note;
    out.append(one);
  }
  return out;
}

std::string segmentation_html(const PartedScan& s) {
  std::vector<std::vector<std::string>> rows{{"part", "in view", "litres", "confidence", ""}};
  for (std::size_t n = 1; n < parts.size(); ++n) {
    const PartFinding& part = s.found.part[n];
    const bool there = part.coverage != Coverage::absent;
    rows.push_back({std::string(parts[n].name), std::string(name_of(part.coverage)),
                    there ? fmt::format("{:.3f}", part.volume * 1e-6) : "",
                    there ? fmt::format("{:.2f}", part.confidence) : "", part.note});
  }
  return html_table(rows, "segmentation: " + in_words(verdict_of(s.found)));
}

void write_parts(const PartedScan& s, const py::object& folder) {
  value_or_throw(
      write_segmentation(path_of(folder), s.found, segmentation_account(s.found, s.input, s.reading)));
}

}  // namespace

void add_segmentation(py::module_& m) {
  using P = PartedScan;
  py::class_<P, std::shared_ptr<P>>(m, "Segmentation",
                                    "The parts of a body, its landmarks, and how sure they are.")
      .def_property_readonly(
          "labels", [](P& s) -> LabelMap& { return s.found.labels; },
          py::return_value_policy::reference_internal, "The parts on the scan's grid.")
      .def_property_readonly(
          "landmarks", [](const P& s) { return dict_of(s.found.landmarks); },
          "Joint centres and bony points by name, mm, LPS, with standard deviations.")
      .def_property_readonly(
          "parts", &findings_of,
          "Per part: label, coverage (whole, cut, absent), volume, confidence (0 to 1), note.")
      .def_property_readonly(
          "verdict", [](const P& s) { return std::string(name_of(verdict_of(s.found).verdict)); },
          "good, doubtful or refused.")
      .def_property_readonly(
          "reasons", [](const P& s) { return verdict_of(s.found).reasons; },
          "Why it is not good, the worst first.")
      .def_property_readonly(
          "warnings", [](const P& s) { return in_sentences(s.found.warnings); },
          "Sentences, the most severe first.")
      .def(
          "to_pandas",
          [](const P& s) {
            return py::module_::import("pandas").attr("DataFrame")(findings_of(s)).attr("set_index")("part");
          },
          "`parts` as a DataFrame, one row per part.")
      .def("write", &write_parts, py::arg("folder"), "Writes the files of `borelli segment -o`.")
      .def("__repr__",
           [](const P& s) {
             return fmt::format("<borelli.Segmentation of '{}': {}>", s.input, in_words(verdict_of(s.found)));
           })
      .def("_repr_html_", &segmentation_html);
  m.def("segment", &run_segmentation, py::arg("volume"), py::kw_only(), py::arg("step") = 3.0,
        py::arg("convention") = "deleva1996", py::arg("landmarks") = py::none(), py::arg("absent") = "",
        py::arg("classes") = py::none(), py::arg("class_names") = "", py::arg("mapping") = "",
        py::arg("threads") = 0, py::arg("callback") = py::none(),
        "Finds the parts and joint centres of a body in a volume.\n\n"
        "step: of the grid on which parts are found, 1 to 6 mm; convention: deleva1996, dempster or bone;\n"
        "landmarks: points placed by hand, by name, mm, LPS; absent: parts that the body lacks, "
        "'thigh_left,...';\n"
        "classes: file of another program's labels, class_names: a TSV of their names, mapping: a ready one\n"
        "(totalsegmentator ...) or a file; threads: 0: all.\n"
        "callback(share, next): 0 to 1, and the next step's name; False stops with an Error.\n\n"
        "The GIL is released. Doubts are DoubtWarnings and stay in `warnings`.");
}

}  // namespace borelli::python
