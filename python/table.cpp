// Inertia tables, the scene made of one, and the sample body.
#include <fmt/core.h>

#include <cmath>
#include <map>

#include "inertia/entries.hpp"
#include "inertia/table_file.hpp"
#include "pipeline/body/measure.hpp"
#include "pipeline/body/mr_scan.hpp"
#include "pipeline/body/segment_rows.hpp"
#include "pipeline/body/skeleton.hpp"
#include "pipeline/files/subject.hpp"
#include "pipeline/files/whole_file.hpp"
#include "process/memory.hpp"
#include "python/model.hpp"
#include "python/segmentation.hpp"
#include "python/volume.hpp"
#include "samples/phantom_voxels.hpp"
#include "segmentation/labelling/verdict.hpp"

namespace borelli::python {
namespace {

using Table = std::shared_ptr<InertiaTable>;

// A row of a table, which it keeps.
struct PartRow {
  std::shared_ptr<const InertiaTable> table;
  const InertiaRow* row;
};

std::vector<PartRow> table_rows(const Table& table) {
  std::vector<PartRow> out;
  for (const InertiaRow& row : table->rows) out.push_back({table, &row});
  out.push_back({table, &table->whole});
  return out;
}

PartRow row_of(const Table& table, const std::string& part) {
  for (const PartRow& row : table_rows(table))
    if (row.row->part == part) return row;
  throw py::key_error(part);
}

std::map<std::string, double> deviations_of(const InertiaRow& row) {
  std::map<std::string, double> out;
  for (const EntryDeviation& deviation : row.deviations) out[deviation.entry] = deviation.total;
  return out;
}

py::dict entries_dict(const PartRow& r) {
  py::dict out;
  for (const Entry& entry : entries_of(*r.table, *r.row)) out[py::str(entry.name)] = entry.value;
  return out;
}

// One row per part and one for the body: its entries, each with its standard deviation as NAME_sd.
py::object table_frame(const Table& table) {
  py::list rows, names;
  for (const PartRow& r : table_rows(table)) {
    const auto deviations = deviations_of(*r.row);
    py::dict cells;
    cells["completeness"] = std::string(name_of(r.row->completeness));
    for (const Entry& entry : entries_of(*table, *r.row)) {
      cells[py::str(entry.name)] = entry.value;
      const auto deviation = deviations.find(entry.name);
      cells[py::str(entry.name + "_sd")] = deviation == deviations.end() ? NAN : deviation->second;
    }
    rows.append(cells);
    names.append(r.row->part);
  }
  const py::module_ pandas = py::module_::import("pandas");
  return pandas.attr("DataFrame")(rows, pandas.attr("Index")(names, py::arg("name") = "part"));
}

std::string table_html(const Table& table) {
  std::vector<std::vector<std::string>> cells{
      {"part", "", "mass, kg", "%", "length, mm", "centre, %", "radii X Y Z, %"}};
  for (const PartRow& r : table_rows(table)) {
    const InertiaRow& row = *r.row;
    std::vector<std::string> line{row.part, std::string(name_of(row.completeness))};
    if (row.completeness != Completeness::absent) {
      const auto deviations = deviations_of(row);
      const auto sd = deviations.find("mass_kg");
      line.push_back(fmt::format("{:.3f}", row.inertial.mass) +
                     (sd == deviations.end() ? "" : fmt::format(" ± {:.3f}", sd->second)));
      line.push_back(fmt::format("{:.2f}", 100 * table->share(row)));
      if (const auto n = anatomical_numbers(row); n && n->length > 0) {
        line.push_back(fmt::format("{:.0f}", 1000 * n->length));
        line.push_back(fmt::format("{:.1f}", 100 * n->centre_along));
        line.push_back(
            fmt::format("{:.1f} {:.1f} {:.1f}", 100 * n->radii[0], 100 * n->radii[1], 100 * n->radii[2]));
      }
    }
    line.resize(cells[0].size());
    cells.push_back(std::move(line));
  }
  return html_table(cells, table->source.volume + ": " + table->source.quantity);
}

py::dict source_of(const InertiaTable& table) {
  const InertiaSource& s = table.source;
  py::dict out;
  for (const auto& [name, text] : {std::pair{"volume", s.volume},
                                   {"quantity", s.quantity},
                                   {"density_curve", s.density_curve},
                                   {"density_source", s.density_source},
                                   {"sampling", s.sampling},
                                   {"sex", s.sex},
                                   {"pose", s.pose},
                                   {"cuts", s.cuts},
                                   {"frames", s.frames},
                                   {"segments", s.segments},
                                   {"segmentation", s.segmentation}})
    out[name] = text;
  out["stature_m"] = s.stature_m;
  return out;
}

struct MeasureAsked {
  std::string density_curve, sampling, convention, frames, sex, pose, segments;
  double blur_reach, stature;
  int threads;
};

MeasureOptions measure_options(const MeasureAsked& asked, const ScannedVolume& scan,
                               const std::vector<std::string>& names) {
  MeasureOptions o;
  o.density_curve = asked.density_curve;
  if (asked.sampling == "points")
    o.sampling = Sampling::points;
  else if (asked.sampling == "averages")
    o.sampling = Sampling::averages;
  else if (asked.sampling != "auto")
    refuse("sampling", "is '" + asked.sampling + "'; expected auto, points or averages");
  o.blur_reach = asked.blur_reach;
  o.frames = asked.frames;
  if (o.frames != "joints" && o.frames != "isb")
    refuse("frames", "are '" + o.frames + "'; expected joints or isb");
  Subject subject = subject_of(scan, asked.sex);
  warn(subject.notes);
  o.sex = std::move(subject.sex);
  o.pose = asked.pose.empty() ? scan.pose : asked.pose;
  o.stature_m = asked.stature;
  o.segments = value_or_throw(choose_segments(asked.segments, names));
  o.threads = asked.threads;
  return o;
}

// What is known of the labels beside their voxels.
struct Known {
  Landmarks landmarks;
  PartCompleteness completeness;
  std::vector<std::string> warnings;
  std::string verdict;
};

Known known_of(const PartedScan* parted, const LabelMap& labels, const py::object& landmarks,
               const GreyVolume& weighed, int threads) {
  Known known{landmarks_of(landmarks), {}, {}, {}};
  if (parted) {
    if (landmarks.is_none()) known.landmarks = parted->found.landmarks;
    known.completeness = completeness_of(parted->found.part);
    known.warnings = in_sentences(parted->found.warnings);
    known.verdict = in_words(verdict_of(parted->found));
  } else {
    known.warnings.push_back(compare_sides(labels));
  }
  if (!known.landmarks.empty())
    known.warnings.push_back(value_or_throw(compare_joints(known.landmarks, labels)));
  if (same_grid(labels.grid, weighed.grid)) {
    const LabelsInAir air = labels_in_air(weighed, labels, threads);
    doubt_what_is_air(air, labels, known.completeness);
    known.warnings.push_back(in_words(air, labels));
  }
  std::erase(known.warnings, "");
  return known;
}

Table measure_parts(const NamedScan& scan, const py::object& given, const py::object& landmarks,
                    const MeasureAsked& asked) {
  const PartedScan* const parted =
      py::isinstance<PartedScan>(given) ? &given.cast<const PartedScan&>() : nullptr;
  const LabelMap& labels =
      parted ? parted->found.labels : object_of<LabelMap>(given, "a borelli.Segmentation or borelli.Labels");
  if (!(asked.stature >= 0 && std::isfinite(asked.stature)))
    refuse("stature",
           fmt::format("is {:g} m; expected a positive number, or 0 if it is unknown", asked.stature));
  if (!(asked.blur_reach >= 0 && std::isfinite(asked.blur_reach)))
    refuse("blur_reach", fmt::format("is {:g} mm; expected a number of at least 0", asked.blur_reach));
  MeasureOptions options = measure_options(asked, scan.scan, labels.names);
  const std::string cuts = parted ? std::string(name_of(parted->found.convention)) : asked.convention;
  if (!cuts.empty()) options.cuts = cuts;
  if (parted && !asked.convention.empty() && asked.convention != cuts)
    refuse("convention", "of this segmentation is " + cuts + "; leave it out, or segment again");
  const GreyVolume& volume = scan.scan.volume;
  std::optional<GreyVolume> density;
  if (volume.quantity == Quantity::mr) {
    const MrReading mr = released([&] { return read_mr(volume, nullptr, asked.threads); });
    density = densities_by_parts(mr, labels, options);
  }
  const GreyVolume& weighed = density ? *density : volume;
  const Known known = known_of(parted, labels, landmarks, weighed, asked.threads);
  auto table = std::make_shared<InertiaTable>(
      released([&] { return measure(weighed, labels, known.landmarks, options, known.completeness); }));
  table->source.volume = scan.name;
  table->source.quantity = scan.scan.reading;
  table->source.segmentation = known.verdict;
  if (options.frames == "isb" && table->source.frames != "isb") table->warnings.emplace_back(no_isb_frames);
  warn(table->warnings);
  table->warnings.insert(table->warnings.begin(), known.warnings.begin(), known.warnings.end());
  if (!parted) warn(known.warnings);  // those of a segmentation were given with it
  return table;
}

std::shared_ptr<ModelFile> skeleton_of(const Table& table, const py::object& given, const std::string& name,
                                       bool leap) {
  const Landmarks landmarks = landmarks_of(given);
  std::vector<std::string> sentences{value_or_throw(compare_centres(*table, landmarks))};
  std::erase(sentences, "");
  std::vector<Warning> warnings;
  SkeletonOptions options;
  options.name = name;
  if (!leap) options.leap.reset();
  options.absent = stated_absent(*table);
  auto skeleton = value_or_throw(build_skeleton(movable_parts(*table, warnings), landmarks, options));
  warnings.insert(warnings.end(), skeleton.warnings.begin(), skeleton.warnings.end());
  const auto more = in_sentences(warnings);
  sentences.insert(sentences.end(), more.begin(), more.end());
  warn(sentences);
  auto model = std::make_shared<ModelFile>();
  model->scene = std::move(skeleton.scene);
  return model;
}

struct SampleBody {
  std::shared_ptr<NamedScan> volume = std::make_shared<NamedScan>();
  std::shared_ptr<LabelMap> labels;
  Landmarks landmarks;
  Table table;
};

Table exact_table(const Phantom& phantom, const PhantomOptions& body) {
  InertiaSource source;
  source.volume = "phantom";
  source.quantity = "the phantom's solids, integrated exactly (no voxels)";
  source.density_curve = body.density_curve;
  source.density_source = value_or_throw(density_curve(body.density_curve)).source;
  source.sex = body.child ? "" : body.sex == Sex::female ? "female" : "male";
  source.pose = body.pose_deg.empty() ? "standing" : "as requested";
  source.cuts = "deleva1996", source.frames = "joints";
  return std::make_shared<InertiaTable>(
      make_table(std::move(source), rows_of_parts(phantom.exact, phantom.volume, phantom.landmarks)));
}

SampleBody phantom_of(const PhantomOptions& body, const GridOptions& grid_options,
                      const ScanOptions& options) {
  value_or_throw(check_scan(grid_options, options));
  const Phantom phantom = value_or_throw(build_phantom(body));
  const Grid grid = phantom_grid(phantom, grid_options);
  value_or_throw(admit_memory("spacing", "the phantom's grid", bytes_of_scan(grid, options)));
  SampleBody out;
  Scan scan = released([&] { return voxelise(phantom, grid, options); });
  out.volume->scan.volume = std::move(scan.grey);
  out.volume->scan.reading = "CT numbers (hu), of the phantom";
  out.volume->name = "phantom";
  out.labels = std::make_shared<LabelMap>(std::move(scan.labels));
  out.landmarks = phantom.landmarks;
  out.table = exact_table(phantom, body);
  return out;
}

void add_rows(py::module_& m) {
  py::class_<PartRow>(
      m, "Row", "The inertia of one part, in the patient's axes (x left, y back, z up). Arrays are views.")
      .def_property_readonly(
          "part", [](const PartRow& r) { return r.row->part; }, "Its name, or 'body'.")
      .def_property_readonly(
          "completeness", [](const PartRow& r) { return std::string(name_of(r.row->completeness)); },
          "whole, cut or absent.")
      .def_property_readonly(
          "mass", [](const PartRow& r) { return r.row->inertial.mass; }, "kg.")
      .def_property_readonly(
          "volume", [](const PartRow& r) { return r.row->volume; }, "m^3.")
      .def_property_readonly(
          "centre",
          [](const py::object& self) { return view(self.cast<const PartRow&>().row->inertial.centre, self); },
          "Gravity centre, (3,), m.")
      .def_property_readonly(
          "tensor",
          [](const py::object& self) { return view(self.cast<const PartRow&>().row->inertial.tensor, self); },
          "Inertia matrix about the gravity centre, (3, 3), kg m^2; Ixy = -integral xy dm.")
      .def_property_readonly("entries", &entries_dict,
                             "Every number of the row by name, with its unit in the name.")
      .def_property_readonly(
          "deviations", [](const PartRow& r) { return deviations_of(*r.row); },
          "Standard deviations by the entry's name.")
      .def_property_readonly(
          "notes", [](const PartRow& r) { return r.row->notes; }, "In plain words.")
      .def("__repr__", [](const PartRow& r) {
        return fmt::format("<borelli.Row {}, {}, {:.4g} kg>", r.row->part, name_of(r.row->completeness),
                           r.row->inertial.mass);
      });
}

void add_table(py::module_& m) {
  py::class_<InertiaTable, Table>(
      m, "Table", "Mass, gravity centre and inertia matrix of each part, with standard deviations.")
      .def_property_readonly("rows", &table_rows, "One per part, and the last for the body.")
      .def("__getitem__", &row_of, py::arg("part"), "The row of a part, or of 'body'.")
      .def_property_readonly("source", &source_of, "Where the table comes from, by name.")
      .def_readonly("warnings", &InertiaTable::warnings, "Doubts about its inputs and the body.")
      .def("to_pandas", &table_frame,
           "A DataFrame: one row per part and one for the body; each entry has its unit in its name, and its "
           "standard deviation in the column NAME_sd.")
      .def(
          "to_csv", [](const InertiaTable& t) { return to_csv(t); }, "As `borelli inertia -o table.csv`.")
      .def(
          "to_json", [](const InertiaTable& t) { return to_json(t); }, "As `borelli inertia -o table.json`.")
      .def(
          "write",
          [](const InertiaTable& t, const py::object& path) {
            value_or_throw(write_whole(
                path_of(path), [&](const std::filesystem::path& part) { return write_table(part, t); }));
          },
          py::arg("path"), "Writes .csv or .json.")
      .def("__repr__",
           [](const InertiaTable& t) {
             return fmt::format("<borelli.Table of '{}', {} parts, {:.2f} kg>", t.source.volume,
                                t.rows.size(), t.whole.inertial.mass);
           })
      .def("_repr_html_", &table_html);
  m.def(
      "read_table",
      [](const py::object& path) {
        auto table = std::make_shared<InertiaTable>(value_or_throw(read_table(path_of(path))));
        warn(table->warnings);
        return table;
      },
      py::arg("path"), "Reads a table that was written as .json.");
}

}  // namespace

void add_tables(py::module_& m) {
  add_rows(m);
  add_table(m);
  m.def(
      "inertia",
      [](const NamedScan& volume, const py::object& labels, const py::object& landmarks,
         const std::string& density_curve, const std::string& sampling, double blur_reach,
         const std::string& convention, const std::string& frames, const std::string& sex, double stature,
         const std::string& pose, const std::string& segments, int threads) {
        return measure_parts(
            volume, labels, landmarks,
            {density_curve, sampling, convention, frames, sex, pose, segments, blur_reach, stature, threads});
      },
      py::arg("volume"), py::arg("labels"), py::kw_only(), py::arg("landmarks") = py::none(),
      py::arg("density_curve") = "", py::arg("sampling") = "auto", py::arg("blur_reach") = 2.0,
      py::arg("convention") = "", py::arg("frames") = "joints", py::arg("sex") = "", py::arg("stature") = 0.0,
      py::arg("pose") = "", py::arg("segments") = "", py::arg("threads") = 0,
      "The inertia table of a volume's parts.\n\n"
      "labels: a Segmentation, with its landmarks, or Labels; landmarks: by name, mm, LPS; density_curve: "
      "by\n"
      "name, of CT numbers; sampling: what a voxel is: auto, points or averages; blur_reach: mm; "
      "convention:\n"
      "how Labels were cut (default deleva1996); frames: joints or isb; sex: male or female; stature: m;\n"
      "segments: 'trunk,arm_left' merges parts; threads: 0: all.\n\n"
      "The GIL is released. Doubts are DoubtWarnings and stay in `warnings`.");
  m.def(
      "skeleton", &skeleton_of, py::arg("table").none(false), py::arg("landmarks").none(false), py::kw_only(),
      py::arg("name") = "body", py::arg("leap") = true,
      "The Scene of a table's parts, joined at the landmarks. leap: it starts with a somersault, its joints\n"
      "are springs; otherwise it rests without springs. Doubts are DoubtWarnings.");
  py::class_<SampleBody>(m, "Phantom",
                         "The sample body as a scan, with its exact landmarks and inertia table.")
      .def_readonly("volume", &SampleBody::volume, "CT numbers.")
      .def_readonly("labels", &SampleBody::labels, "The part of each voxel's centre.")
      .def_property_readonly(
          "landmarks", [](const SampleBody& s) { return dict_of(s.landmarks); }, "Exact, mm, LPS.")
      .def_readonly("table", &SampleBody::table, "Integrated exactly from its solids.");
  m.def(
      "phantom",
      [](const std::string& sex, bool child, const py::object& variation, const py::object& stature,
         const py::object& mass, const std::map<std::string, double>& pose, double spacing, double noise,
         double blur, bool partial_volume, std::uint64_t seed, int threads) {
        if (sex != "male" && sex != "female") refuse("sex", "is '" + sex + "'; expected male or female");
        PhantomOptions body;
        body.sex = sex == "female" ? Sex::female : Sex::male;
        body.child = child;
        if (!variation.is_none()) body.variation = variation.cast<std::uint64_t>();
        if (!stature.is_none()) body.stature_m = stature.cast<double>();
        if (!mass.is_none()) body.mass_kg = mass.cast<double>();
        body.pose_deg = pose;
        GridOptions grid;
        grid.spacing.setConstant(spacing);
        ScanOptions scan;
        scan.noise_hu = noise, scan.blur_mm = blur, scan.partial_volume = partial_volume;
        scan.seed = seed, scan.threads = threads;
        return phantom_of(body, grid, scan);
      },
      py::kw_only(), py::arg("sex") = "male", py::arg("child") = false, py::arg("variation") = py::none(),
      py::arg("stature") = py::none(), py::arg("mass") = py::none(),
      py::arg("pose") = std::map<std::string, double>(), py::arg("spacing") = 3.0, py::arg("noise") = 0.0,
      py::arg("blur") = 0.0, py::arg("partial_volume") = false, py::arg("seed") = 1, py::arg("threads") = 0,
      "The sample body as a scan.\n\n"
      "variation: seed of a random body; stature: m; mass: kg; pose: {'knee_left_flexion': 30} in degrees;\n"
      "spacing: mm; noise: HU; blur: mm; partial_volume: voxels are averages, not points; seed: of the "
      "noise.");
}

}  // namespace borelli::python
